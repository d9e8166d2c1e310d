//! Where in its file a triangle comes from, and what was lost on the way.

use std::collections::{HashMap, HashSet};

/// The faces and bodies of a file.
#[derive(Clone, Debug, Default)]
pub struct Source {
    /// The first triangle of each face, if faces may have other numbers of triangles than one.
    pub(crate) faces: Vec<u32>,
    names: Vec<String>,
    /// The first triangle of each run of triangles of one body, ascending, and the number of the body.
    runs: Vec<(u32, u32)>,
    /// Whether coordinates are rounded to f32.
    pub(crate) in_f32: bool,
    /// If they are, the number of coordinates that are written with more digits than the nearest f32 has, or that the file
    /// has or places in f64 where no f32 is.
    pub(crate) rounded: usize,
}

/// Numbers all but the first of those that have one name: `Lid`, `Lid (2)`.
pub fn name_apart<'n>(names: impl Iterator<Item = &'n mut String>) {
    let (mut taken, mut counts) = (HashSet::new(), HashMap::new());
    for name in names {
        let plain = name.clone();
        let count = counts.entry(plain.clone()).or_insert(1_usize);
        while !taken.insert(name.clone()) {
            *count += 1;
            *name = format!("{plain} ({count})");
        }
    }
}

impl Source {
    /// A position that the file does not write as decimals, in the precision that is asked for.
    pub(crate) fn rounded(&mut self, position: [f64; 3]) -> [f64; 3] {
        if !self.in_f32 {
            return position;
        }
        position.map(|x| {
            let nearest = f64::from(x as f32);
            // NaN is no difference.
            self.rounded += usize::from((nearest - x).abs() > 0.0);
            nearest
        })
    }

    /// Begins a new body with the triangle that comes next, and returns its number.
    pub(crate) fn begin_body(&mut self, name: String, triangles: usize) -> u32 {
        let body = self.names.len() as u32;
        self.names.push(name);
        self.resume_body(body, triangles);
        body
    }

    /// Forgets the bodies so far, whose triangles are of none.
    pub(crate) fn forget_bodies(&mut self) {
        self.names.clear();
        self.runs.clear();
    }

    /// Goes on with a body.
    pub(crate) fn resume_body(&mut self, body: u32, triangles: usize) {
        let triangle = triangles as u32;
        // A run without triangles is none.
        self.runs.pop_if(|last| last.0 == triangle);
        self.runs.push((triangle, body));
    }

    /// Forgets bodies without triangles, and names the others apart.
    pub(crate) fn end_bodies(&mut self, triangles: usize) {
        self.runs.pop_if(|last| last.0 as usize == triangles);
        if self.runs.first().is_some_and(|first| first.0 > 0) {
            self.runs.insert(0, (0, self.names.len() as u32));
            self.names.push("default".to_owned());
        }
        let mut numbers = vec![None; self.names.len()];
        let mut names = Vec::new();
        for (_, body) in &mut self.runs {
            let number = numbers[*body as usize].get_or_insert_with(|| {
                names.push(std::mem::take(&mut self.names[*body as usize]));
                names.len() as u32 - 1
            });
            *body = *number;
        }
        name_apart(names.iter_mut());
        self.names = names;
    }

    /// The face of a triangle, from 0 in the file; in STL, glTF and 3MF the triangle's own number, from 0 in its body.
    pub fn face(&self, triangle: u32) -> u32 {
        match self.faces.partition_point(|&first| first <= triangle) {
            0 => triangle - self.run(triangle).map_or(0, |(first, _)| first),
            after => after as u32 - 1,
        }
    }

    /// The name of the body of a triangle, if the file has bodies; no two of a file have the same.
    pub fn body(&self, triangle: u32) -> Option<&str> {
        self.run(triangle).map(|(_, body)| &self.names[body as usize][..])
    }

    fn run(&self, triangle: u32) -> Option<(u32, u32)> {
        let after = self.runs.partition_point(|&(first, _)| first <= triangle);
        self.runs.get(after.checked_sub(1)?).copied()
    }

    /// The bodies of the file: objects or else groups of an OBJ, solids of an STL, nodes of a glTF, items of a 3MF. None if the file
    /// does not tell.
    pub fn bodies(&self) -> &[String] {
        &self.names
    }

    /// The triangles of each body, ascending; `triangles` are those of the file.
    pub fn triangles(&self, triangles: usize) -> Vec<Vec<u32>> {
        let mut bodies = vec![Vec::new(); self.names.len()];
        let ends = self.runs.iter().skip(1).map(|run| run.0).chain([triangles as u32]);
        for (&(first, body), end) in self.runs.iter().zip(ends) {
            bodies[body as usize].extend(first..end);
        }
        bodies
    }
}
