//! Recorded meshes in contact, for the suite of [`crate`]. They may not be redistributed, so they
//! are read from a folder: the one that `PFRONT_DATA` names (see `test.sh`).

use crate::suite::{Body, Contacts, Site, Suite};
use anyhow::{Context, Result};
use pfront::{Model, Pose};
use pfront_files::{TriangleMesh, read_f32};
use serde::Deserialize;
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// The sets, and with what the names of the recorded cases in each begin.
const CASES: [(&str, &[&str]); 4] = [
    ("bunnies", &["bunny_"]),
    ("buddhas", &["buddha_"]),
    ("dragons", &["dragon"]),
    ("recorded gears", &["gear", "worm_drive"]),
];

/// Frames of a garment in motion, of which one position takes 12 bytes.
const KICK: (&str, &str, [usize; 4]) = (
    "cloth/kick/kick_frame000.ply",
    "cloth/kick/kick_positions_121x12811x3.f32le",
    [30, 60, 90, 120],
);

/// Pairs of broken, coplanar and coincident meshes. Not the generic twins: 48 million of their boxes overlap.
const NASTY_PAIRS: [(&str, &str); 8] = [
    ("ballA.off", "ballB.off"),
    ("self_intersectA.obj", "self_intersectB.obj"),
    ("Offset3.obj", "Offset4.obj"),
    ("Havocglass8_left.obj", "Havocglass8_right.obj"),
    ("center_cylinder.obj", "offset_cylinder.obj"),
    ("elephant.off", "elephant-with-holes.off"),
    ("patch-20.off", "patch-21.off"),
    ("stairs.obj", "wallhole.obj"),
];

/// Meshes that meet themselves.
const NASTY_SELVES: [&str; 9] = [
    "cylinder_locally_refined.off",
    "degtri_sliding.off",
    "elephant-with-holes.off",
    "issue289_1.obj",
    "patch-20.off",
    "same_mesh_far_from_origin.obj",
    "soup.stl",
    "stairs.obj",
    "wallhole.obj",
];

/// A recorded case: two meshes, and the pose of the second.
#[derive(Deserialize)]
struct Case {
    name: String,
    a: String,
    b: String,
    rotation_row_major: [f64; 9],
    translation: [f64; 3],
}

/// The suite of generated pairs, of scenes of about `size` triangles or as many as is usual, and what the folder
/// that `PFRONT_DATA` names has recorded. Without it, standard error says what is missing.
///
/// # Errors
/// As [`contacts`].
pub fn suite(seed: u64, size: Option<usize>) -> Result<Suite> {
    let suite = Suite::generated(seed, size)?;
    let Some(folder) = std::env::var_os("PFRONT_DATA") else {
        eprintln!(
            "PFRONT_DATA is not set: no pairs of bunnies, Buddhas, dragons, recorded gears, cloth, nasty"
        );
        return Ok(suite);
    };
    Ok(contacts(Path::new(&folder))?.into_iter().fold(suite, Suite::with))
}

/// Bunnies, Buddhas, dragons, gears, cloth and the nasty set, from a folder of recorded data.
///
/// # Errors
/// If a file cannot be read, or is not what it should be.
pub fn contacts(folder: &Path) -> Result<Vec<Contacts>> {
    let mut library = Library { folder, bodies: HashMap::new() };
    let path = folder.join("oracle/cases.json");
    let named = || path.display().to_string();
    let cases: Vec<Case> = serde_json::from_slice(&read(&path)?).with_context(named)?;
    let mut sets = Vec::new();
    for (set, beginnings) in CASES {
        let belongs = |case: &&Case| beginnings.iter().any(|b| case.name.starts_with(b));
        let sites = cases.iter().filter(belongs).map(|case| library.case(case));
        sets.push(Contacts::new(set, sites.collect::<Result<_, _>>()?)?);
    }
    sets.push(Contacts::new("cloth", library.cloth()?)?);
    sets.push(Contacts::new("nasty", library.nasty()?)?);
    Ok(sets)
}

/// Bodies by their files.
struct Library<'p> {
    folder: &'p Path,
    bodies: HashMap<String, Body>,
}

impl Library<'_> {
    fn body(&mut self, file: &str) -> Result<Body> {
        if let Some(body) = self.bodies.get(file) {
            return Ok(body.clone());
        }
        let path = self.folder.join(file);
        let TriangleMesh { positions, triangles } = read_f32(&path)?;
        let body = Model::new(positions, triangles).map(Arc::new);
        let body = body.with_context(|| path.display().to_string())?;
        self.bodies.insert(file.to_owned(), body.clone());
        Ok(body)
    }

    fn pair(&mut self, a: &str, b: &str, a_from_b: Pose) -> Result<Site> {
        Ok(Site::Pair { a: self.body(a)?, b: self.body(b)?, a_from_b })
    }

    fn case(&mut self, case: &Case) -> Result<Site> {
        let row = |i: usize| {
            let [x, y, z] = [0, 1, 2].map(|k| case.rotation_row_major[3 * i + k] as f32);
            [x, y, z, case.translation[i] as f32]
        };
        self.pair(&case.a, &case.b, Pose::new([0, 1, 2].map(row)))
    }

    fn cloth(&mut self) -> Result<Vec<Site>> {
        let mut sites = Vec::new();
        for file in ["cloth/cloth_ball/cloth_ball92.ply", "cloth/cloth_ball/cloth_ball93.ply"] {
            sites.push(Site::Within(self.body(file)?));
        }
        let (first, positions, frames) = KICK;
        let garment = self.body(first)?;
        let path = self.folder.join(positions);
        let bytes = read(&path)?;
        let size = 12 * garment.mesh().vertex_count();
        for frame in frames {
            let short = || format!("{} ends before frame {frame}", path.display());
            let bytes = bytes.get(frame * size..(frame + 1) * size).with_context(short)?;
            let positions: Vec<[f32; 3]> = bytemuck::pod_collect_to_vec(bytes);
            let mut moved = Model::clone(&garment);
            moved.set_positions(&positions).with_context(|| path.display().to_string())?;
            sites.push(Site::Within(Arc::new(moved)));
        }
        Ok(sites)
    }

    fn nasty(&mut self) -> Result<Vec<Site>> {
        let mut sites = Vec::new();
        for (a, b) in NASTY_PAIRS {
            sites.push(self.pair(&format!("nasty/{a}"), &format!("nasty/{b}"), Pose::IDENTITY)?);
        }
        for file in NASTY_SELVES {
            sites.push(Site::Within(self.body(&format!("nasty/{file}"))?));
        }
        Ok(sites)
    }
}

fn read(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).with_context(|| {
        format!("cannot read {}: PFRONT_DATA must name the folder of recorded data", path.display())
    })
}
