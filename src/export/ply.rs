//! Meshes as PLY files, binary, little endian.

use crate::render::Mesh;

/// A PLY file with position, normal (nx, ny, nz) and place in the maps (u, v) of each vertex, and triangles.
///
/// # Source
/// Turk 1994, The PLY Polygon File Format, version 1.0.
#[must_use]
pub fn ply(mesh: &Mesh) -> Vec<u8> {
    let properties: String =
        ["x", "y", "z", "nx", "ny", "nz", "u", "v"].map(|name| format!("property float {name}\n")).concat();
    let head = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n{properties}element face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    );
    let mut file = head.into_bytes();
    file.reserve(32 * mesh.vertices.len() + 13 * mesh.triangles.len());
    file.extend(mesh.vertices.iter().flatten().flat_map(|value| value.to_le_bytes()));
    for triangle in &mesh.triangles {
        file.push(3);
        file.extend(triangle.iter().flat_map(|vertex| vertex.to_le_bytes()));
    }
    file
}
