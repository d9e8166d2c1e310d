//! `pfront check MESH…`

use super::scene::{Part, body_name, split};
use super::{check_files, read};
use crate::args::Check;
use crate::listing::{HIT, Origin, PLAIN, count, posed};
use crate::progress::shown;
use anyhow::{Context, Result, ensure};
use pfront::{Allowed, BodyId, CheckReport, CheckedPair, ContactSize, Pose, Relation, SceneQuery};
use pfront_cli::json::{VERSION, write_json};
use pfront_cli::output::{Draft, out};
use pfront_files::escape::escaped;
use pfront_files::{PaintedMesh, name_apart, write_painted};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use wildmatch::WildMatch;

/// Names of bodies by their ids.
type Names = BTreeMap<BodyId, String>;

/// Where the triangles of bodies come from.
type Origins<'f> = BTreeMap<BodyId, Origin<'f>>;

pub(crate) fn run(asked: &Check) -> Result<bool> {
    let Check { meshes, ignore, reading, executor, .. } = asked;
    let picture = asked.picture.as_deref();
    check_files(&meshes.iter().map(PathBuf::as_path).collect::<Vec<_>>(), picture)?;
    let mut scene = SceneQuery::new().on(&executor.open()?);
    scene.within(asked.clearance.unwrap_or(0.0))?;
    let (mut parts, mut sources) = (Vec::new(), Vec::new());
    let (of_files, distance) = reading.bodies_apart();
    for (file, path) in meshes.iter().enumerate() {
        let loaded = shown(format!("reading {}", path.display()), || read(path, &of_files))?;
        sources.push(split(loaded, path, body_name(path, meshes), file, distance, &mut parts)?);
    }
    name_apart(parts.iter_mut().map(|part| &mut part.name));
    let (mut names, mut origins, mut counts) = (Names::new(), Origins::new(), BTreeMap::new());
    for Part { name, model, file, triangles } in parts {
        let count = model.mesh().triangles().len();
        let id = scene.add(Arc::new(model), Pose::IDENTITY).with_context(|| name.clone())?;
        counts.insert(id, count);
        origins.insert(id, Origin { name: name.clone(), source: &sources[file], triangles });
        names.insert(id, name);
    }
    for two in ignore.chunks_exact(2) {
        let [a, b] = [&two[0], &two[1]].map(|pattern| named(&names, pattern));
        let (a, b) = (a?, b?);
        for (&a, &b) in a.iter().flat_map(|a| b.iter().map(move |b| (a, b))) {
            if a != b {
                scene.ignore(a, b, true)?;
            }
        }
    }
    let mut allowed = Allowed {
        overlap_volume: asked.allow_overlap,
        with_contacts: asked.patches,
        ..Allowed::default()
    };
    for word in &asked.allow {
        allowed.relations.push(relation(word)?);
    }
    let report = shown("checking the bodies".to_owned(), || anyhow::Ok(scene.check(&allowed)?))?;
    for (id, error) in &report.refused {
        eprintln!("{}: no solid: {error}", escaped(&names[id]));
    }
    if let Some(path) = picture {
        shown("drawing".to_owned(), || draw(&mut scene, &report, path))?;
    }
    match (asked.json, asked.csv) {
        (true, _) => write_json(&mut out(), &as_json(&report, &names, &counts, &origins))?,
        (_, true) => write_csv(&report, &names)?,
        _ => write_text(&report, &names)?,
    }
    Ok(report.is_allowed())
}

/// The bodies that a name or a pattern names.
fn named(names: &Names, pattern: &str) -> Result<Vec<BodyId>> {
    let exact: Vec<_> =
        names.iter().filter(|(_, name)| *name == pattern).map(|(id, _)| *id).collect();
    if !exact.is_empty() {
        return Ok(exact);
    }
    let matched = WildMatch::new(pattern);
    let found: Vec<_> =
        names.iter().filter(|(_, name)| matched.matches(name)).map(|(id, _)| *id).collect();
    ensure!(!found.is_empty(), "there is no body {pattern}");
    Ok(found)
}

fn relation(word: &str) -> Result<Relation> {
    let words = || Relation::ALL.map(Relation::as_str).join(", ");
    Relation::from_word(word)
        .with_context(|| format!("{word} is no relation; there are {}", words()))
}

fn word(pair: &CheckedPair) -> &'static str {
    pair.relation.map_or("undetermined", Relation::as_str)
}

/// A pair as JSON; what was not asked is not there.
fn pair_json(pair: &CheckedPair, names: &Names, origins: &Origins<'_>) -> Value {
    let mut object = Map::new();
    let mut add = |name: &str, value: Value| object.insert(name.to_owned(), value);
    add("a", json!(names[&pair.bodies[0]]));
    add("b", json!(names[&pair.bodies[1]]));
    add("relation", json!(word(pair)));
    add("meets", json!(pair.meets));
    add("allowed", json!(pair.is_allowed));
    if let Some(gap) = pair.gap {
        add("gap", json!(gap));
    }
    if let Some(volume) = pair.overlap_volume {
        add("overlap_volume", json!(volume));
    }
    if let Some(ContactSize { dimension, patches, length, area }) = pair.contact {
        let size = json!({
            "dimension": dimension,
            "regions": patches,
            "length": length,
            "area": area,
        });
        add("contact", size);
    }
    if let Some(place) = pair.place {
        add("place", json!(place));
    }
    if let Some(triangles) = pair.pair {
        let both = [triangles.a, triangles.b];
        add("triangles", json!(both));
        add("faces", json!([0, 1].map(|k| origins[&pair.bodies[k]].face(both[k]))));
    }
    Value::Object(object)
}

fn as_json(
    report: &CheckReport,
    names: &Names,
    triangles: &BTreeMap<BodyId, usize>,
    origins: &Origins<'_>,
) -> Value {
    let body = |(id, name): (&BodyId, &String)| {
        let refused = report.refused.iter().find(|(other, _)| other == id);
        let mut object = json!({ "name": name, "triangles": triangles[id] });
        if let Some((_, error)) = refused {
            object["refused"] = json!(error.to_string());
        }
        object
    };
    let mut counts = BTreeMap::<_, u64>::new();
    report.pairs.iter().for_each(|pair| *counts.entry(word(pair)).or_default() += 1);
    json!({
        "version": VERSION,
        "bodies": names.iter().map(body).collect::<Vec<_>>(),
        "pairs": report.pairs.iter().map(|pair| pair_json(pair, names, origins)).collect::<Vec<_>>(),
        "counts": counts,
        "allowed": report.is_allowed(),
    })
}

fn interval([low, high]: [f64; 2]) -> String {
    format!("{low:e}..{high:e}")
}

fn write_csv(report: &CheckReport, names: &Names) -> Result<()> {
    let mut rows = csv::Writer::from_writer(out());
    rows.write_record(["body_a", "body_b", "relation", "allowed", "meets", "low", "high"])?;
    for pair in &report.pairs {
        let [low, high] = match pair.overlap_volume.or(pair.gap) {
            Some(interval) => interval.map(|x| x.to_string()),
            None => Default::default(),
        };
        let [a, b] = pair.bodies.map(|id| escaped(&names[&id]).into_owned());
        let [allowed, meets] = [pair.is_allowed, pair.meets].map(|is| is.to_string());
        rows.write_record([&a, &b, word(pair), &allowed, &meets, &low, &high])?;
    }
    rows.flush()?;
    Ok(())
}

fn write_text(report: &CheckReport, names: &Names) -> Result<()> {
    let mut out = out();
    for pair in report.pairs.iter().filter(|pair| !pair.is_allowed) {
        let [a, b] = pair.bodies.map(|id| escaped(&names[&id]));
        write!(out, "{a}  {b}  {}", word(pair))?;
        if let Some(volume) = pair.overlap_volume {
            write!(out, "  volume {}", interval(volume))?;
        }
        if let Some(gap) = pair.gap {
            write!(out, "  gap {}", interval(gap))?;
        }
        if let Some(ContactSize { patches, length, area, .. }) = pair.contact {
            let regions = count(patches, "region");
            write!(out, "  {regions}, length {}, area {}", interval(length), interval(area))?;
        }
        if let Some([x, y, z]) = pair.place {
            write!(out, "  at {x} {y} {z}")?;
        }
        writeln!(out)?;
    }
    let refused = report.pairs.iter().filter(|pair| !pair.is_allowed).count();
    let (bodies, pairs) = (names.len(), count(report.pairs.len(), "pair"));
    let bodies = if bodies == 1 { "1 body".to_owned() } else { format!("{bodies} bodies") };
    writeln!(out, "{bodies}, {pairs} of them whose boxes overlap, {refused} not allowed")?;
    Ok(())
}

/// Colours of triangles of bodies that meet, that are near each other, and of bodies inside others, where that is not allowed.
const COLOURS: [[u8; 3]; 4] = [PLAIN[0], HIT, [232, 190, 40], [60, 90, 220]];

/// Writes all bodies as a PLY file.
fn draw(scene: &mut SceneQuery, report: &CheckReport, path: &Path) -> Result<()> {
    let not_allowed: BTreeMap<_, _> = report
        .pairs
        .iter()
        .filter(|pair| !pair.is_allowed)
        .map(|pair| (pair.bodies, pair.relation))
        .collect();
    let mut marks: BTreeMap<BodyId, Vec<u8>> = scene
        .bodies()
        .map(|body| (body.id(), vec![0; body.model().mesh().triangles().len()]))
        .collect();
    for (bodies, relation) in &not_allowed {
        let inner = match relation {
            Some(Relation::AInB) => bodies[0],
            Some(Relation::BInA) => bodies[1],
            _ => continue,
        };
        marks.entry(inner).and_modify(|marks| marks.fill(3));
    }
    for hit in scene.all()? {
        let Some(relation) = not_allowed.get(&hit.bodies) else { continue };
        let mark = if *relation == Some(Relation::Near) { 2 } else { 1 };
        for (body, triangle) in hit.bodies.into_iter().zip([hit.pair.a, hit.pair.b]) {
            if let Some(marks) = marks.get_mut(&body) {
                let own = &mut marks[triangle as usize];
                *own = if *own == 1 { 1 } else { mark };
            }
        }
    }
    let is_f64 = scene.bodies().any(|body| body.model().is_f64());
    let bodies: Vec<_> = scene
        .bodies()
        .map(|body| (body, posed(body.model().mesh(), &body.pose(), is_f64)))
        .collect();
    let painted: Vec<_> = bodies
        .iter()
        .map(|(body, positions)| PaintedMesh {
            positions,
            triangles: body.model().mesh().triangles(),
            marks: &marks[&body.id()],
            colours: &COLOURS,
        })
        .collect();
    let mut file = Draft::new(path)?;
    write_painted(&mut file, &painted)
        .with_context(|| format!("cannot write {}", path.display()))?;
    file.finish()
}
