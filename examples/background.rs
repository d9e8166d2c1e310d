//! A game's loop that does not wait: a scene is asked in the background while the frame is drawn.
//!
//! `cargo run --release --example background`, with `-- gpu` on the best GPU (`--features gpu`). Prints how long the loop was
//! blocked: by submitting, and by reading what has not come while it drew.

use pfront::{Error, Executor, Model, Pose, SceneQuery};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Balls in the scene.
const BALLS: usize = 1_000;
const FRAMES: usize = 60;
/// The time in which a frame is drawn.
const DRAWS: Duration = Duration::from_millis(10);

fn main() -> Result<(), Error> {
    let executor = executor()?;
    let (mut scene, ball) = (SceneQuery::new().on(&executor), Arc::new(ball(24)?));
    let bodies = (0..BALLS).map(|i| scene.add(ball.clone(), pose(i, 0)));
    let bodies: Vec<_> = bodies.collect::<Result<_, _>>()?;
    let (mut blocked, mut meetings) = (Vec::new(), 0);
    for frame in 0..FRAMES {
        for (i, &body) in bodies.iter().enumerate() {
            scene.set_pose(body, pose(i, frame))?;
        }
        // The scene goes with the question, so that nobody can change it meanwhile.
        let clock = Instant::now();
        let ticket = executor.submit(move || scene.update().map(|()| scene))?;
        let submitting = clock.elapsed();
        draw();
        // It comes back with its hits.
        let clock = Instant::now();
        scene = ticket.read()??;
        blocked.push([submitting, clock.elapsed()]);
        meetings += scene.hits().chunk_by(|x, y| x.bodies == y.bodies).count();
    }
    assert!(meetings > 0);
    println!("{}", scene.plan().map(ToString::to_string).unwrap_or_default());
    for (side, what) in ["submitting", "reading"].iter().enumerate() {
        let mut times: Vec<_> = blocked.iter().map(|both| both[side]).collect();
        times.sort();
        println!("{what}: median {:?}, longest {:?}", times[FRAMES / 2], times[FRAMES - 1]);
    }
    Ok(())
}

#[cfg(feature = "gpu")]
fn executor() -> Result<Executor, Error> {
    if std::env::args().any(|argument| argument == "gpu") {
        let gpu = pfront::gpu::Gpu::new()?;
        return Ok(Executor::gpu(&gpu, gpu.settings()));
    }
    Ok(Executor::threads(8))
}

#[cfg(not(feature = "gpu"))]
fn executor() -> Result<Executor, Error> {
    Ok(Executor::threads(8))
}

/// Takes the time of a renderer.
fn draw() {
    std::thread::sleep(DRAWS);
}

/// Balls in a row of three, which swings.
fn pose(ball: usize, frame: usize) -> Pose {
    let swing = (0.1 * frame as f32 + ball as f32).sin();
    let [x, y] = [ball % 40, ball / 40].map(|at| 1.9 * at as f32);
    Pose::from_translation([x + 0.2 * swing, y, 0.3 * swing])
}

/// A ball of radius 1 with so many quads around.
fn ball(side: u32) -> Result<Model, Error> {
    let (across, down) = (std::f32::consts::TAU / side as f32, std::f32::consts::PI / side as f32);
    let corner = |i: u32| {
        let ((sin, cos), (low, high)) =
            ((across * (i % side) as f32).sin_cos(), (down * (i / side) as f32).sin_cos());
        [low * cos, high, low * sin]
    };
    let quads = (0..side * side).map(|i| {
        let next = i - i % side + (i + 1) % side;
        [i, next, next + side, i + side]
    });
    let triangles = quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Model::new((0..side * (side + 1)).map(corner).collect(), triangles)
}

#[test]
fn runs() -> Result<(), Error> {
    main()
}
