//! Cloth whose steps never pass through: a sheet that falls fast on a thin plate, and on itself.
//!
//! `cargo run --release --example cloth_motion`
//!
//! In one step it would fall through the plate and intersect it in no frame. Each step is asked about as a motion, and shortened until nothing
//! meets on the way (as in Li et al., *Incremental Potential Contact*, 2020, whose barrier would keep it from coming so near that steps get
//! short; here whatever was hit is stopped).

use pfront::{Error, Model, Motion, PairQuery, Pose, SelfQuery};

/// Quads along each side of the sheet.
const SIDE: usize = 24;
/// The plate is at this height, and has no thickness.
const PLATE: f32 = -0.5;

fn main() -> Result<(), Error> {
    let plate = Model::new(
        vec![[-0.4, PLATE, -0.4], [0.4, PLATE, -0.4], [0.4, PLATE, 0.4], [-0.4, PLATE, 0.4]],
        vec![[0, 1, 2], [0, 2, 3]],
    )?;
    let mut positions: Vec<[f32; 3]> = (0..=SIDE * (SIDE + 2)).map(at).collect();
    let row = SIDE as u32 + 1;
    let corners = (0..row - 1).flat_map(|i| (0..row - 1).map(move |j| i * row + j));
    let triangles: Vec<_> =
        corners.flat_map(|k| [[k, k + 1, k + row], [k + 1, k + row + 1, k + row]]).collect();
    // The models at both ends of a step: the end of one is the start of the next.
    let mut now = Model::new(positions.clone(), triangles.clone())?;
    let mut then = Model::new(positions.clone(), triangles.clone())?;
    let (mut on_plate, mut on_itself) = (PairQuery::new(), SelfQuery::new());

    let mut speeds = vec![[0.0_f32, -1.0, 0.0]; positions.len()];
    let (mut shortened, mut stopped) = (0, 0);
    for step in 0..12 {
        let mut part = 1.0_f32;
        let mut hit = Vec::new();
        let moved = loop {
            let moved: Vec<[f32; 3]> = positions
                .iter()
                .zip(&speeds)
                .map(|(p, v)| [0, 1, 2].map(|axis| p[axis] + part * v[axis]))
                .collect();
            then.set_positions(&moved)?;
            let motion = Motion::between(&now, &then)?;
            let with_plate = on_plate.impacts(&Motion::at_rest(&plate), &motion)?;
            let with_itself = on_itself.impacts(&motion)?;
            let all = with_plate.iter().map(|(pair, impact)| (None, pair.b, impact));
            let all =
                all.chain(with_itself.iter().map(|(pair, impact)| (Some(pair.a), pair.b, impact)));
            let first = all.clone().map(|(.., impact)| impact.from).reduce(f64::min);
            let Some(first) = first else { break moved };
            // Triangles are stopped that are hit before the others will have moved far.
            let soon = all.filter(|(.., impact)| impact.from <= first + 0.2);
            hit.extend(soon.flat_map(|(a, b, _)| a.into_iter().chain([b])));
            // A shorter step is rounded anew, and so it is asked about again.
            part *= 0.75 * first as f32;
            shortened += 1;
        };
        positions = moved;
        std::mem::swap(&mut now, &mut then);
        // Neither frame tells what happened between, but each has to be free of hits.
        assert_eq!(on_plate.count(&plate, &now, Pose::IDENTITY)? + on_itself.count(&now)?, 0);
        hit.sort_unstable();
        hit.dedup();
        println!("step {step}: {part:.6} of it, {} triangles stopped", hit.len());
        for &vertex in hit.iter().flat_map(|&triangle| &triangles[triangle as usize]) {
            stopped += usize::from(speeds[vertex as usize] != [0.0; 3]);
            speeds[vertex as usize] = [0.0; 3];
        }
        fall(&positions, &mut speeds);
    }
    let above = |p: &[f32; 3]| p[0].abs() > 0.35 || p[2].abs() > 0.35 || p[1] > PLATE;
    assert!(shortened > 0 && stopped > 0 && positions.iter().all(above));
    Ok(())
}

/// Speeds a step later: what has not been stopped falls on, held back by the vertices beside it.
fn fall(positions: &[[f32; 3]], speeds: &mut [[f32; 3]]) {
    let row = SIDE + 1;
    let before = speeds.to_vec();
    for (vertex, speed) in speeds.iter_mut().enumerate() {
        if *speed == [0.0; 3] {
            continue;
        }
        let (i, j) = (vertex / row, vertex % row);
        let mut beside = Vec::with_capacity(4);
        beside.extend(i.checked_sub(1).map(|i| i * row + j));
        beside.extend(j.checked_sub(1).map(|j| i * row + j));
        beside.extend((i < SIDE).then_some(vertex + row));
        beside.extend((j < SIDE).then_some(vertex + 1));
        for other in beside {
            for axis in 0..3 {
                // A spring that pulls only, and friction between neighbours.
                let length = distance(positions[vertex], positions[other]);
                let pull = 0.2 * (1.0 - 1.0 / (length * SIDE as f32)).max(0.0);
                speed[axis] += pull * (positions[other][axis] - positions[vertex][axis])
                    + 0.1 * (before[other][axis] - before[vertex][axis]);
            }
        }
        speed[1] -= 0.02;
    }
}

fn distance(p: [f32; 3], q: [f32; 3]) -> f32 {
    (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f32>().sqrt()
}

/// A vertex of the sheet at the beginning: level, but for a wrinkle.
fn at(vertex: usize) -> [f32; 3] {
    let [u, v] = [vertex / (SIDE + 1), vertex % (SIDE + 1)].map(|k| k as f32 / SIDE as f32 - 0.5);
    [u, 0.05 * (9.0 * u).sin() * (7.0 * v).cos(), v]
}

#[test]
fn runs() -> Result<(), Error> {
    main()
}
