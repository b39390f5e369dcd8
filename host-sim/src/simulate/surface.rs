//! A bone's surface of triangles.

/// A surface of triangles, in metres along the array's axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// The surface with these corners, m, and triangles of their indices.
    pub fn new(vertices: Vec<[f64; 3]>, triangles: Vec<[u32; 3]>) -> Self {
        Surface {
            vertices,
            triangles,
        }
    }

    /// The corners, m.
    pub fn vertices(&self) -> &[[f64; 3]] {
        &self.vertices
    }

    /// The corners of every triangle, m.
    pub fn corners(&self) -> impl Iterator<Item = [[f64; 3]; 3]> + '_ {
        let corner = |index: u32| self.vertices[index as usize];
        self.triangles.iter().map(move |t| t.map(corner))
    }
}
