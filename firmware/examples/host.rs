//! Prints what the firmware is to print, after comparing the pairs of each frame with those that `pfront`
//! finds by another build and a wider walk.

use pfront::{Model, PairQuery};
use scene::{Memory, Pairs, beads, play, pose, torus};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let own =
        |mesh: pfront::Mesh<'_>| Model::new(mesh.shadow().to_vec(), mesh.triangles().to_vec());
    let (a, b) = (own(torus()?)?, own(beads()?.mesh())?);
    let mut query = PairQuery::new();
    let mut frames = Vec::new();
    play(&mut Box::new(Memory::ZERO), |pairs, line| frames.push((pairs, *line)))?;
    for (number, (found, line)) in (0..).zip(frames) {
        let mut truth = Pairs::default();
        query.all(&a, &b, &pose(number))?.iter().for_each(|&pair| truth.add(pair));
        if found != truth {
            return Err(format!("frame {number}: {found:?}, and not {truth:?}").into());
        }
        print!("{}", line.as_c_str().to_str()?);
    }
    Ok(())
}
