//! The arguments of the command line.

mod impacts;
mod listing;

pub(crate) use impacts::Impacts;
pub(crate) use listing::{Format, Listing};

use anyhow::Result;
use clap::builder::RangedU64ValueParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;
use pfront::pfront_core::Distance;
use pfront::pfront_core::bvh::MAX_LEAF_SIZE;
use pfront::{AnyPose, Pose, Pose64};
use pfront_cli::executor::{Backend, ExecutorArgs, parse_threads};
use pfront_files::{FORMATS, ReadOptions, Weld};
use std::ffi::OsString;
use std::num::NonZero;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  pfront demo                                     120 frames of two torus knots, with timings
  pfront pairs a.obj b.stl --translate 0.1,0,0    every intersecting triangle pair
  pfront pairs a.obj b.stl --out hits.ply         the same, to look at
  pfront any a.obj b.stl && echo they touch
  pfront distance a.obj b.stl                     how far apart they are, and where
  pfront impacts wall.obj ball.obj --translate-end 0,0,-2   what the ball hits on its way, and when
  pfront self cloth.ply --csv > folds.csv
  pfront scene room.glb --ignore 'Lid*' Box       the bodies of a scene that meet, by name
  pfront scene room.glb --bodies --within 0.5     the bodies that are at most so far apart
  pfront check assembly.glb --clearance 0.5       whether its bodies clash, or are too near
  pfront bake gear.obj && pfront self gear.pfb    with the BVH that was built once
  pfront pairs a.obj b.obj --out curve.obj        the curves in which they intersect
  pfront bench a.obj b.stl                        how fast this machine is

Exit codes:
  0  done; for any: something meets, or is within the distance; for distance: they are; for check: all is allowed
  1  for any, distance, impacts --first and impacts --any: nothing is so; for check: something is not allowed; with --fail: something is
  2  the command line or a file was refused; standard error says why
  130  interrupted";

/// Finds every pair of intersecting triangles between two meshes, or within one, exactly
#[derive(Debug, Parser)]
#[command(name = "pfront", version, after_help = EXAMPLES)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// List all intersecting triangle pairs of two meshes
    ///
    /// Triangles count from 0, in the order of their file.
    Pairs {
        #[command(flatten)]
        meshes: TwoMeshes,
        #[command(flatten)]
        listing: Listing,
        #[command(flatten)]
        executor: ExecutorArgs,
    },
    /// Time 120 frames of two built-in torus knots on this machine
    Demo,
    /// Test whether two meshes intersect (exit code 0 or 1), and print one pair
    Any {
        #[command(flatten)]
        meshes: TwoMeshes,
        #[command(flatten)]
        executor: ExecutorArgs,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Tell the smallest distance of two meshes, between which triangles, and from which point to which
    ///
    /// Prints the interval that holds it, 0 if they intersect. With --within, only if they are at most so far apart, exactly: if
    /// not, the exit code is 1. CPUs answer.
    Distance {
        #[command(flatten)]
        meshes: TwoMeshes,
        #[command(flatten)]
        executor: ExecutorArgs,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// List the triangle pairs of two moving meshes, or of one that deforms, that meet on the way, and when
    ///
    /// Every vertex goes in a straight line, from its place at time 0 to that at time 1. Prints for each pair the time before which it does
    /// not meet and that before which it certainly does; inf if that is open, as where triangles touch and do not pass. No pair is
    /// missed. CPUs answer. With --first, the pair that meets first alone, with --any, some pair: the exit code is 1 if there is none.
    Impacts(Impacts),
    /// List the self-intersections of meshes, each by itself
    ///
    /// Triangles count from 0, in the order of their file.
    #[command(name = "self")]
    SelfCollision(SelfCollision),
    /// List all intersecting triangle pairs of different bodies
    ///
    /// Bodies are the nodes of glTF files and their instances, the items of 3MF files, the objects of OBJ files, or else their
    /// groups, and the solids of STL files; a file of one body has the name of the file. They stay where the coordinates of
    /// their files put them. One body alone has nothing to meet; for that see pfront self.
    /// Triangles count from 0 within their body.
    Scene(Scene),
    /// Check an assembly: what its bodies are to each other, and whether that is allowed (exit code 0 or 1)
    ///
    /// As a job of continuous integration:
    ///
    ///   clash:
    ///     runs-on: ubuntu-latest
    ///     steps:
    ///       - uses: actions/checkout@v4
    ///       - run: cargo install --path cli  # in a checkout of pfront, until it is on a registry
    ///       - run: >
    ///           pfront check assembly.glb --clearance 0.5 --allow-overlap 0.01
    ///           --ignore 'Bolt*' 'Nut*' --json > report.json
    ///
    /// Every two bodies are apart, near (at most the clearance apart), touching, crossing, a_in_b, b_in_a or equal, exactly; or undetermined,
    /// where a body is open or that hangs on triangles that meet their own mesh. Apart and touching are allowed, nothing else.
    /// Rounding makes flush parts cross by a trifle: --allow-overlap allows volumes. Bodies are those of pfront scene.
    #[command(verbatim_doc_comment)]
    Check(Check),
    /// Write a mesh with its BVH as one blob, for programs and firmware to borrow
    ///
    /// Wherever a mesh is read, a baked one is too. Prints the bytes of each section.
    Bake(Bake),
    /// Time one thread, all threads and a GPU on two meshes, or on two built-in torus knots
    ///
    /// B makes one turn about the z axis through the middle of its box. A frame is from the pose to all pairs in
    /// the memory of the host. The answers are compared.
    #[command(override_usage = "pfront bench [OPTIONS] [A B]")]
    Bench(Bench),
    /// List the adapters that a GPU query could run on, and the default
    Devices {
        /// Print one JSON array
        #[arg(long)]
        json: bool,
    },
    /// Print what completes this command's words in a shell
    ///
    /// As by: pfront completions bash > ~/.local/share/bash-completion/completions/pfront
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Print the manual page of this command
    ///
    /// As by: pfront man > ~/.local/share/man/man1/pfront.1
    Man,
}

/// How meshes are read.
#[derive(Clone, Debug, Default, Args)]
pub(crate) struct Reading {
    /// Format of a mesh whose name does not tell, as that of standard input [default: by how it begins]
    #[arg(long, value_name = "FORMAT", value_parser = FORMATS)]
    input_format: Option<String>,
    /// MB that a mesh may take while it is read, and as many again for baking it or for an answer, which is checked once it is
    /// found [default: reading: 16 times the file and 64 MB, baking: what is free, answer: no bound]
    #[arg(long, value_name = "MB", value_parser = megabytes)]
    pub(crate) memory: Option<usize>,
    /// Round coordinates to f32, and compute poses there: faster, and what graphics do [default: in f64, as written]
    #[arg(long = "f32")]
    pub(crate) in_f32: bool,
    /// Read files that a glTF names outside its own folder too [default: refused, since it may name any file]
    #[arg(long)]
    allow_outside_files: bool,
    /// Join vertices within a distance of each other; without one, those at the same place [default: those at the same
    /// place, in STL, glTF, 3MF, and OBJ with normals or texture coordinates, which split vertices]
    #[arg(long, value_name = "DISTANCE", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "0", value_parser = distance)]
    weld: Option<f64>,
    /// Keep vertices apart that the file numbers apart
    #[arg(long, conflicts_with = "weld")]
    no_weld: bool,
}

impl Reading {
    pub(crate) fn options(&self) -> ReadOptions {
        ReadOptions {
            format: self.input_format.clone(),
            memory: self.memory,
            in_f32: self.in_f32,
            allow_outside_files: self.allow_outside_files,
            weld: match (self.weld, self.no_weld) {
                (Some(distance), _) => Weld::Within(distance),
                (None, true) => Weld::Never,
                (None, false) => Weld::Split,
            },
        }
    }

    /// The same, with vertices of a file joined only at the same place; and the distance within which those of one body are.
    pub(crate) fn bodies_apart(&self) -> (Self, Option<f64>) {
        (Self { weld: self.weld.map(|_| 0.0), ..self.clone() }, self.weld)
    }
}

fn distance(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|x: &f64| *x >= 0.0 && x.is_finite());
    number.ok_or_else(|| "not a distance".to_owned())
}

/// The words of the command line, with `--weld=1e-6` in place of `--weld 1e-6`: what follows may be a file just as well.
pub(crate) fn words(words: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut all: Vec<OsString> = Vec::new();
    for word in words {
        let is_distance = word.to_str().is_some_and(|text| distance(text).is_ok());
        match all.last_mut().filter(|last| is_distance && *last == "--weld") {
            Some(last) => {
                last.push("=");
                last.push(word);
            }
            None => all.push(word),
        }
    }
    all
}

/// How near triangles are asked for.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct Near {
    /// Ask for pairs at most so far apart in place of those that intersect, exactly; rounded up to f32, so that no pair is missed.
    /// Triangles of one mesh that share a vertex are decided as without. Contacts and curves are those of pairs that intersect. GPUs answer
    /// about two meshes only
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true, value_parser = near)]
    pub(crate) within: Option<f32>,
}

impl Near {
    /// The distance, which is 0 for pairs that intersect.
    pub(crate) fn distance(self) -> f32 {
        self.within.unwrap_or(0.0)
    }
}

/// The least f32 that is not below a distance.
fn near(text: &str) -> Result<f32, String> {
    let distance = text.parse::<f64>().map_err(|_| "not a number".to_owned())?;
    let distance = Distance::at_least(distance).map_err(|error| error.to_string())?;
    Ok(distance.get())
}

fn megabytes(text: &str) -> Result<usize, String> {
    let number = text.parse::<usize>().ok().and_then(|number| number.checked_mul(1_000_000));
    number.ok_or_else(|| "not a number of MB".to_owned())
}

#[derive(Debug, Args)]
pub(crate) struct TwoMeshes {
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// The first mesh: obj, ply, stl, off, gltf, glb, 3mf, or pfb from bake; - is standard input
    pub(crate) a: PathBuf,
    /// The second mesh
    pub(crate) b: PathBuf,
    /// Pose of B in the frame of A: 12 numbers separated by commas, a 3×4 matrix row by row
    #[arg(long, value_name = "M", allow_hyphen_values = true, conflicts_with_all = ["translate", "rotate"])]
    #[arg(value_parser = matrix)]
    pose: Option<[f64; 12]>,
    /// Move B
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = numbers::<3>)]
    translate: Option<[f64; 3]>,
    /// First turn B about an axis through its origin, in degrees
    #[arg(long, value_name = "X,Y,Z,DEGREES", allow_hyphen_values = true)]
    #[arg(value_parser = rotation)]
    rotate: Option<[f64; 4]>,
    #[command(flatten)]
    pub(crate) near: Near,
}

impl TwoMeshes {
    /// The pose `a_from_b`: in f64, unless f32 is asked for or nothing moves.
    pub(crate) fn a_from_b(&self) -> AnyPose {
        let rows = self.rows();
        if self.reading.in_f32 || rows == Pose64::IDENTITY.rows {
            Pose::new(rows.map(|row| row.map(|x| x as f32))).into()
        } else {
            Pose64::new(rows).into()
        }
    }

    fn rows(&self) -> [[f64; 4]; 3] {
        if let Some(m) = self.pose {
            return rows_of(m);
        }
        let [x, y, z, degrees] = self.rotate.unwrap_or_default();
        let axis = glam::DVec3::new(x, y, z).normalize_or_zero();
        let turn = glam::DQuat::from_scaled_axis(axis * degrees.to_radians());
        let [tx, ty, tz] = self.translate.unwrap_or_default();
        let matrix = glam::DMat3::from_quat(turn);
        let row = |i: usize, t: f64| [matrix.col(0)[i], matrix.col(1)[i], matrix.col(2)[i], t];
        [row(0, tx), row(1, ty), row(2, tz)]
    }
}

/// Numbers between commas.
fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parsed = text.split(',').map(|part| match part.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("'{part}' is not a finite number; needs {N}, separated by commas")),
    });
    let parsed: Vec<f64> = parsed.collect::<Result<_, _>>()?;
    let found = parsed.len();
    parsed.try_into().map_err(|_| format!("needs {N} numbers, separated by commas, not {found}"))
}

/// A pose, which must leave something of a mesh.
fn matrix(text: &str) -> Result<[f64; 12], String> {
    let rows = numbers::<12>(text)?;
    let is_point = rows.chunks_exact(4).all(|row| row[..3] == [0.0; 3]);
    if is_point { Err("it would shrink B to a point".to_owned()) } else { Ok(rows) }
}

/// The rows of twelve numbers.
fn rows_of(m: [f64; 12]) -> [[f64; 4]; 3] {
    [0, 4, 8].map(|i| [m[i], m[i + 1], m[i + 2], m[i + 3]])
}

/// An axis, which must have a length, and degrees.
fn rotation(text: &str) -> Result<[f64; 4], String> {
    let numbers = numbers::<4>(text)?;
    if numbers[..3] == [0.0; 3] { Err("the axis has no length".to_owned()) } else { Ok(numbers) }
}

#[derive(Debug, Args)]
pub(crate) struct SelfCollision {
    /// The meshes
    #[arg(required = true)]
    pub(crate) meshes: Vec<PathBuf>,
    /// Leave out every pair that shares a vertex
    #[arg(long)]
    pub(crate) skip_neighbours: bool,
    #[command(flatten)]
    pub(crate) near: Near,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) listing: Listing,
    #[command(flatten)]
    pub(crate) executor: ExecutorArgs,
}

#[derive(Debug, Args)]
pub(crate) struct Scene {
    /// The meshes
    #[arg(required = true)]
    pub(crate) meshes: Vec<PathBuf>,
    /// Leave out hits of two bodies, by their names or by those of their files, where * stands for any characters and ? for
    /// one; may be given again
    #[arg(long, num_args = 2, value_names = ["BODY", "BODY"])]
    pub(crate) ignore: Vec<String>,
    /// Leave out hits of the bodies that the first two columns of a CSV file name, as --bodies --csv writes it
    #[arg(long, value_name = "FILE")]
    pub(crate) ignore_file: Option<PathBuf>,
    /// List only which bodies meet: a line for each two, with the number of their triangle pairs
    #[arg(long, conflicts_with_all = ["contacts", "source"])]
    pub(crate) bodies: bool,
    #[command(flatten)]
    pub(crate) near: Near,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) listing: Listing,
    #[command(flatten)]
    pub(crate) executor: ExecutorArgs,
}

#[derive(Debug, Args)]
pub(crate) struct Check {
    /// The meshes
    #[arg(required = true)]
    pub(crate) meshes: Vec<PathBuf>,
    /// Bodies at most so far apart are near, which is not allowed without --allow near
    #[arg(long, value_name = "DISTANCE", allow_hyphen_values = true, value_parser = near)]
    pub(crate) clearance: Option<f32>,
    /// Allow these relations too: near, crossing, a_in_b, b_in_a, equal
    #[arg(long, value_name = "RELATION", value_delimiter = ',')]
    pub(crate) allow: Vec<String>,
    /// Allow bodies to cross if their common volume is certainly at most this
    #[arg(long, value_name = "VOLUME", default_value_t = 0.0, value_parser = distance)]
    pub(crate) allow_overlap: f64,
    /// Measure contacts too: their patches, the length of curves and outlines, and areas
    #[arg(long)]
    pub(crate) patches: bool,
    /// Leave out two bodies, by their names, where * stands for any characters and ? for one; may be given again
    #[arg(long, num_args = 2, value_names = ["BODY", "BODY"])]
    pub(crate) ignore: Vec<String>,
    /// Print one JSON object: see docs/check.md
    #[arg(long, conflicts_with = "csv")]
    pub(crate) json: bool,
    /// Print all pairs as CSV
    #[arg(long)]
    pub(crate) csv: bool,
    /// Also write the bodies into a .ply file, with what is not allowed in colour: triangles of bodies that meet in red, gaps in yellow,
    /// bodies inside others in blue
    #[arg(long, value_name = "FILE", value_parser = picture)]
    pub(crate) picture: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) executor: ExecutorArgs,
}

/// The file of a picture.
fn picture(path: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(path);
    match path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ply")) {
        true => Ok(path),
        false => Err("a picture is a .ply file".to_owned()),
    }
}

#[derive(Debug, Args)]
pub(crate) struct Bake {
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
    /// The mesh
    pub(crate) mesh: PathBuf,
    /// Where to [default: the current folder, under the name of the mesh, as .pfb]
    #[arg(short, long, value_name = "FILE")]
    pub(crate) out: Option<PathBuf>,
    /// How the BVH is built
    #[arg(long, value_enum, default_value_t = Build::Sah)]
    pub(crate) build: Build,
    /// The most triangles a leaf may hold
    #[arg(long, value_name = "N", default_value_t = MAX_LEAF_SIZE)]
    #[arg(value_parser = RangedU64ValueParser::<u32>::new().range(1..=MAX_LEAF_SIZE as u64))]
    pub(crate) leaf_size: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Build {
    /// With the surface area heuristic: traversed fastest
    Sah,
    /// Along a Morton curve, as a device without much memory would
    Morton,
}

#[derive(Debug, Args)]
pub(crate) struct Bench {
    /// Two meshes [default: two torus knots]
    #[arg(num_args = 2, value_names = ["A", "B"])]
    pub(crate) meshes: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// How many frames
    #[arg(long, value_name = "N", default_value = "120")]
    pub(crate) frames: NonZero<u32>,
    /// CPU threads to compare with one [default: all]
    #[arg(long, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<NonZero<usize>>,
    /// Whether a GPU takes part
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub(crate) backend: Backend,
    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}
