//! Answers to look at: meshes with marked triangles as a binary PLY that every viewer opens, and polylines as OBJ.

use std::io::{self, Write};

/// A mesh to paint.
#[derive(Clone, Copy, Debug)]
pub struct PaintedMesh<'m> {
    /// Vertex positions.
    pub positions: &'m [[f64; 3]],
    /// Three vertex indices per triangle, in range.
    pub triangles: &'m [[u32; 3]],
    /// The mark of each triangle, a place in the colours, of which the last stands for all farther ones.
    pub marks: &'m [u8],
    /// Red, green and blue by marks. Without any, all triangles are black.
    pub colours: &'m [[u8; 3]],
}

/// Writes meshes as one PLY file, of floats if these hold every coordinate, else of doubles. Each triangle has three vertices of its own, since viewers colour
/// vertices rather than faces.
///
/// # Errors
/// Fails as `to` does, which is written piece by piece and wants a buffer.
///
/// # Panics
/// If a triangle has an index out of range.
pub fn write_painted(to: &mut impl Write, meshes: &[PaintedMesh<'_>]) -> io::Result<()> {
    let triangles: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
    let is_f32 = |x: &f64| f64::from(*x as f32) == *x;
    let in_f32 = meshes.iter().all(|mesh| mesh.positions.as_flattened().iter().all(is_f32));
    let real = if in_f32 { "float" } else { "double" };
    write!(
        to,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty {real} x\nproperty {real} y\n\
         property {real} z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face {triangles}\nproperty list uchar uint vertex_indices\nend_header\n",
        3 * triangles
    )?;
    for mesh in meshes {
        let last = mesh.colours.last().copied().unwrap_or_default();
        for (triangle, &mark) in mesh.triangles.iter().zip(mesh.marks) {
            let colour = mesh.colours.get(usize::from(mark)).copied().unwrap_or(last);
            for &v in triangle {
                for x in mesh.positions[v as usize] {
                    if in_f32 {
                        to.write_all(&(x as f32).to_le_bytes())?;
                    } else {
                        to.write_all(&x.to_le_bytes())?;
                    }
                }
                to.write_all(&colour)?;
            }
        }
    }
    for first in (0..triangles).map(|i| 3 * i as u32) {
        to.write_all(&[3])?;
        (first..first + 3).try_for_each(|v| to.write_all(&v.to_le_bytes()))?;
    }
    Ok(())
}

/// Writes polylines as OBJ: points with as many digits as tell them from others of their precision, and the indices of those
/// along each line.
///
/// # Errors
/// Fails as `to` does, which is written piece by piece and wants a buffer.
pub fn write_polylines(
    to: &mut impl Write,
    points: &[[f64; 3]],
    lines: &[Vec<u32>],
    in_f32: bool,
) -> io::Result<()> {
    for point in points {
        if in_f32 {
            let [x, y, z] = point.map(|x| x as f32);
            writeln!(to, "v {x} {y} {z}")?;
        } else {
            let [x, y, z] = point;
            writeln!(to, "v {x} {y} {z}")?;
        }
    }
    for line in lines {
        write!(to, "l")?;
        line.iter().try_for_each(|point| write!(to, " {}", point + 1))?;
        writeln!(to)?;
    }
    Ok(())
}
