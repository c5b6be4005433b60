//! Meshes to trace and numbers to make them from.

use glam::Vec3;
use lightshaft::compare::Numbers;
use lightshaft::tracer::TraceMesh;

/// A facet more, made of the triangles of a fan around its first corner.
pub(crate) fn add_facet(mesh: &mut TraceMesh, corners: &[Vec3]) {
    let (base, facet) = (mesh.positions.len() as u32, mesh.first_triangle.len() as u32 - 1);
    mesh.positions.extend(corners);
    for i in 1..corners.len() as u32 - 1 {
        mesh.triangles.push([base, base + i, base + i + 1]);
        mesh.facet_of_triangle.push(facet);
    }
    mesh.first_triangle.push(mesh.triangles.len() as u32);
}

fn empty() -> TraceMesh {
    TraceMesh { first_triangle: vec![0], ..TraceMesh::default() }
}

/// Two-triangle facets of all sizes, a third of them axis-parallel.
pub(crate) fn soup(count: u32, seed: u64) -> TraceMesh {
    let mut numbers = Numbers(seed);
    let mut mesh = empty();
    for facet in 0..count {
        let corner = numbers.point();
        let size = 0.01 + 0.3 * numbers.next_number() * numbers.next_number();
        let (u, v) = match facet % 9 {
            0 => (Vec3::X * size, Vec3::Y * size),
            1 => (Vec3::Y * size, Vec3::Z * size),
            2 => (Vec3::Z * size, Vec3::X * size),
            _ => (numbers.point() * size, numbers.point() * size),
        };
        add_facet(&mut mesh, &[corner, corner + u, corner + u + v, corner + v]);
    }
    mesh
}

/// From a thousandth to a hundred-thousandth of the size of the scene.
fn tiny(numbers: &mut Numbers) -> f32 {
    1e-5 * 100f32.powf(numbers.next_number())
}

/// Triangles as large as the scene, and tiny ones.
pub(crate) fn tiny_and_huge(count: u32, seed: u64) -> TraceMesh {
    let mut numbers = Numbers(seed);
    let mut mesh = empty();
    for facet in 0..count {
        let (corner, tiny) = (numbers.point(), tiny(&mut numbers));
        let corners = match facet % 8 {
            0 => [corner, numbers.point(), numbers.point()],
            _ => [corner, corner + numbers.point() * tiny, corner + numbers.point() * tiny],
        };
        add_facet(&mut mesh, &corners);
    }
    mesh
}

/// Triangles as long as the scene and tiny across.
pub(crate) fn slivers(count: u32, seed: u64) -> TraceMesh {
    let mut numbers = Numbers(seed);
    let mut mesh = empty();
    for _ in 0..count {
        let (corner, tiny) = (numbers.point(), tiny(&mut numbers));
        add_facet(&mut mesh, &[corner, numbers.point(), corner + numbers.point() * tiny]);
    }
    mesh
}

/// A closed shell of triangles, one a facet, that share their vertices: a bumpy ball, or a box whose walls
/// are grids of coplanar squares.
pub(crate) fn shell(is_box: bool) -> TraceMesh {
    const CELLS: u32 = 6;
    let mut mesh = empty();
    for (axis, sign) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0f32)] {
        // The same numbers for a corner on every wall that has it.
        let corner = |i: u32, j: u32| {
            let at = |k: u32| (2.0 * k as f32 - CELLS as f32) / CELLS as f32;
            let mut p = Vec3::ZERO;
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (sign, at(i), at(j));
            if is_box {
                return p * 0.7;
            }
            let bump = 1.0 + 0.1 * (p.x * 7.0 + p.y * 5.0 + p.z * 3.0).sin();
            // Summed in one order whatever the wall.
            p * (0.6 * bump / (p.x * p.x + p.y * p.y + p.z * p.z).sqrt())
        };
        for i in 0..CELLS {
            for j in 0..CELLS {
                let square = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                add_facet(&mut mesh, &[square[0], square[1], square[2]]);
                add_facet(&mut mesh, &[square[0], square[2], square[3]]);
            }
        }
    }
    mesh
}
