//! docs/questions.md is the page of all that can be asked: its names exist, all verbs are on it, and its answers are those of plans.

use std::collections::BTreeSet;
use std::fs::read_to_string;
use std::path::Path;

fn text(path: &str) -> String {
    read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// The rows of the table whose first cell of the header is this.
fn rows(page: &str, header: &str) -> Vec<Vec<String>> {
    let rows = page.lines().skip_while(|line| !line.starts_with(&format!("| {header} |")));
    let cells = |line: &str| -> Vec<String> {
        line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    rows.skip(2).take_while(|line| line.starts_with('|')).map(cells).collect()
}

/// The names that a text has in backquotes.
fn names(text: &str) -> BTreeSet<&str> {
    text.split('`').skip(1).step_by(2).collect()
}

/// The names of the public functions of some files.
fn functions(paths: &[&str]) -> BTreeSet<String> {
    let name = |line: &str| {
        let rest = line.trim_start().strip_prefix("pub fn ")?;
        Some(rest.split(['(', '<']).next()?.to_owned())
    };
    paths.iter().flat_map(|path| text(path).lines().filter_map(name).collect::<Vec<_>>()).collect()
}

/// The files of all queries.
const QUERIES: [&str; 11] = [
    "src/pair.rs",
    "src/relation.rs",
    "src/itself.rs",
    "src/impacts.rs",
    "src/scene/mod.rs",
    "src/scene/edit.rs",
    "src/scene/nearest.rs",
    "src/scene/check.rs",
    "src/scene/impacts.rs",
    "src/scene/segment.rs",
    "src/batch/mod.rs",
];

#[test]
fn every_verb_is_on_the_page_and_no_other_name() {
    let page = text("docs/questions.md");
    let (questions, about) = (rows(&page, "question"), rows(&page, "about a query"));
    assert!(questions.len() >= 7 && about.len() >= 10);
    let on_page: BTreeSet<_> =
        questions.iter().chain(&about).flat_map(|row| names(&row[1])).collect();
    let public = functions(&QUERIES);
    let public: BTreeSet<_> = public.iter().map(String::as_str).collect();
    assert_eq!(on_page, public);

    let once = page.lines().find(|line| line.starts_with("Once,")).unwrap();
    let own = functions(&["src/once.rs"]);
    let once: BTreeSet<_> = names(once).into_iter().map(|name| &name["pfront::".len()..]).collect();
    assert_eq!(once, own.iter().map(String::as_str).collect());
}

#[test]
fn other_languages_have_what_the_page_says() {
    let page = text("docs/questions.md");
    let [python, scene] = ["_questions.py", "_scene.py"]
        .map(|file| text(&format!("bindings/python/python/pfront/{file}")));
    let (c, command) = (text("capi/include/pfront.h"), text("cli/src/args.rs"));
    let web =
        ["pair.rs", "scene.rs"].map(|file| text(&format!("bindings/web/cpu/src/{file}"))).concat();
    for row in rows(&page, "question") {
        for name in names(&row[5]) {
            let is_named = web.contains(&format!("js_name = {name})"));
            assert!(is_named || web.contains(&format!("pub fn {name}(")), "{name}");
        }
        for name in names(&row[2]) {
            let definition = format!("def {name}(");
            assert!(python.contains(&definition) || scene.contains(&definition), "{name}");
        }
        for name in names(&row[3]) {
            assert!(c.contains(&format!(" {name}(")), "{name}");
        }
        for name in names(&row[4]) {
            let variant = name[..1].to_uppercase() + &name[1..];
            let is_named = command.contains(&format!("name = \"{name}\""));
            assert!(is_named || command.contains(&format!("\n    {variant}")), "{name}");
        }
    }
}

/// The rows of "Who answers", from the plans of questions.
#[cfg(feature = "gpu")]
fn who_answers() -> Vec<Vec<String>> {
    use pfront::executor::Plan;
    use pfront::gpu::Gpu;
    use pfront::{
        Adjacency, Batch, BodyOptions, Executor, Model, PairQuery, Pose, SceneQuery, SelfQuery,
    };
    use std::ops::ControlFlow;
    use std::sync::Arc;
    // Two balls in one mesh, which intersect.
    let mut ball = pfront_testkit::scenes::icosphere(80);
    let count = ball.positions.len();
    for i in 0..count {
        ball.positions.push(ball.positions[i].map(|x| x + 0.3));
    }
    for i in 0..ball.triangles.len() {
        ball.triangles.push(ball.triangles[i].map(|vertex| vertex + count as u32));
    }
    let in_f64 = ball.positions.iter().map(|p| p.map(|x| f64::from(x) + 1e-12)).collect();
    let models = [
        ("f32", Model::new(ball.positions.clone(), ball.triangles.clone())),
        ("f64", Model::from_f64(in_f64, ball.triangles)),
    ];
    let models = models.map(|(precision, model)| (precision, Arc::new(model.unwrap())));
    let still = models[0].1.clone();
    let gpu = Gpu::new().unwrap();
    let executors = [Executor::sequential(), Executor::gpu(&gpu, gpu.settings())];
    let aside = |frame| Pose::from_translation([0.1 + 0.01 * frame as f32, 0.0, 0.0]);
    let backend = |plan: Option<&Plan>| plan.unwrap().backend.to_string();

    let mut rows = Vec::new();
    let mut add = |query: &str, verb: &str, backends: [String; 2]| {
        let row = [query, verb, &backends[0], &backends[1]].map(str::to_owned);
        rows.push(row.to_vec());
    };
    for (precision, model) in &models {
        for verb in ["any", "all", "count", "contacts", "patches", "visit", "distance"] {
            let ask = |executor: &Executor| {
                let mut query = PairQuery::new().on(executor);
                let (a, b, pose) = (&still, model, aside(0));
                match verb {
                    "any" => query.any(a, b, pose).map(drop),
                    "all" => query.all(a, b, pose).map(drop),
                    "count" => query.count(a, b, pose).map(drop),
                    "contacts" => query.contacts(a, b, pose).map(drop),
                    "patches" => query.patches(a, b, pose).map(drop),
                    "distance" => query.distance(a, b, pose).map(drop),
                    _ => query.visit(a, b, pose, |_| ControlFlow::Continue(())).map(drop),
                }
                .unwrap();
                backend(query.plan())
            };
            add(&format!("pair, one in {precision}"), verb, executors.each_ref().map(ask));
        }
    }
    for (precision, model) in &models {
        for verb in ["any", "all", "count", "contacts", "visit"] {
            let ask = |executor: &Executor| {
                let mut query = SelfQuery::new().on(executor);
                match verb {
                    "any" => query.any(model).map(drop).unwrap(),
                    "all" => query.all(model).map(drop).unwrap(),
                    "count" => query.count(model).map(drop).unwrap(),
                    "contacts" => query.contacts(model).map(drop).unwrap(),
                    _ => query.visit(model, |_| ControlFlow::Continue(())).map(drop).unwrap(),
                }
                backend(query.plan())
            };
            add(&format!("self, in {precision}"), verb, executors.each_ref().map(ask));
        }
    }
    let [in_f32, in_f64] = &models;
    for (body, (_, model), itself) in [
        ("in f32", in_f32, None),
        ("in f64", in_f64, None),
        ("with itself", in_f32, Some(Adjacency::default())),
    ] {
        for verb in ["any", "all", "count", "contacts", "visit", "intersecting_bodies", "distance"]
        {
            let ask = |executor: &Executor| {
                let mut scene = SceneQuery::new().on(executor);
                for i in 0..2 {
                    scene.add(still.clone(), aside(i)).unwrap();
                }
                let options = BodyOptions { itself, ..BodyOptions::default() };
                let body = scene.add_with(model.clone(), aside(2), options).unwrap();
                match verb {
                    "any" => scene.any().map(drop),
                    "all" => scene.all().map(drop),
                    "count" => scene.count().map(drop),
                    "contacts" => scene.contacts().map(drop),
                    "distance" => scene.distance(body).map(drop),
                    "intersecting_bodies" => scene.intersecting_bodies().map(drop),
                    _ => scene.visit(|_| ControlFlow::Continue(())).map(drop),
                }
                .unwrap();
                backend(scene.plan())
            };
            add(&format!("scene, a body {body}"), verb, executors.each_ref().map(ask));
        }
    }
    for (precision, model) in &models {
        let ask = |executor: &Executor| {
            let mut batch = Batch::new();
            batch.pair(&still, model, aside(0)).unwrap();
            batch.itself(model, Adjacency::default());
            let ticket = batch.count(executor).unwrap();
            let plans = [0, 1].map(|question| backend(ticket.plan(question).as_ref()));
            ticket.read().unwrap();
            plans
        };
        let [sequential, gpu] = executors.each_ref().map(ask);
        let [pair, within] = [0, 1].map(|i| [sequential[i].clone(), gpu[i].clone()]);
        add(&format!("batch, pair in {precision}"), "each", pair);
        add(&format!("batch, self in {precision}"), "each", within);
    }
    rows
}

#[cfg(feature = "gpu")]
#[test]
fn plans_are_those_of_the_page() {
    // Verbs with the same answer share a row.
    let mut expected: Vec<Vec<String>> = Vec::new();
    for row in who_answers() {
        match expected.last_mut() {
            Some(last) if last[0] == row[0] && last[2..] == row[2..] => {
                last[1] += &format!(", `{}`", row[1]);
            }
            _ => expected.push(vec![
                row[0].clone(),
                format!("`{}`", row[1]),
                row[2].clone(),
                row[3].clone(),
            ]),
        }
    }
    let expected: Vec<_> = expected.iter().map(|row| row.join(" | ")).collect();
    let page = text("docs/questions.md");
    let found: Vec<_> = rows(&page, "query").iter().map(|row| row.join(" | ")).collect();
    assert_eq!(found, expected, "the table should be:\n{}", expected.join("\n"));
}
