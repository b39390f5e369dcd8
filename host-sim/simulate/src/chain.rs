//! Joins the segments of a plane cut into closed loops.

use std::collections::BTreeMap;

/// A point of the image plane: x and z, m.
pub type Point = [f64; 2];

/// A segment whose ends are identified by the edge of the mesh or grid they lie on.
pub struct Segment {
    /// The edges that the two ends lie on.
    pub edges: [(usize, usize); 2],
    /// The two ends.
    pub ends: [Point; 2],
}

/// Joins segments that share edges into closed loops.
///
/// `None` if a chain does not close, that is, if an odd number of segments meet at an edge. The order of the loops
/// follows that of the segments.
pub fn closed_loops(segments: &[Segment]) -> Option<Vec<Vec<Point>>> {
    let mut at_edge: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (index, segment) in segments.iter().enumerate() {
        for edge in segment.edges {
            at_edge.entry(edge).or_default().push(index);
        }
    }
    let mut used = vec![false; segments.len()];
    let mut loops = Vec::new();
    for first in 0..segments.len() {
        if used[first] {
            continue;
        }
        let start = segments[first].edges[0];
        let mut points = Vec::new();
        let mut edge = start;
        let mut index = first;
        loop {
            used[index] = true;
            let from = usize::from(segments[index].edges[0] != edge);
            points.push(segments[index].ends[from]);
            edge = segments[index].edges[1 - from];
            if edge == start {
                break;
            }
            index = *at_edge[&edge].iter().find(|&&next| !used[next])?;
        }
        loops.push(points);
    }
    Some(loops)
}
