//! Points find the leaf element that holds them. A failure means that light lands on, and is looked up from, other
//! elements than it should.

use lightshaft::radiosity::{Forest, Piece};
use lightshaft::visibility::Strategy;

use crate::solving::{Case, links_only, options};

/// From near the corners of an element to its middle.
const INWARDS: [f64; 3] = [0.05, 0.5, 1.0];

/// Whether more than one cell of a side is divided further.
fn has_divided_cells(forest: &Forest) -> bool {
    let is_divided = |element: usize| forest.second[element] != 0 && forest.cell[element] as usize == element;
    (0..forest.side_count())
        .any(|side| forest.elements_of(side).skip(1).filter(|&element| is_divided(element)).count() > 1)
}

#[test]
fn every_leaf_element_is_found_at_its_points() {
    let (mut backs, mut cells, mut deepest) = (0, false, 0);
    for (name, one_sided) in [("paper-1", false), ("paper-3", false), ("paper-3", true)] {
        let case = Case::load(name);
        let case = Case::of(case.scene, one_sided);
        let hierarchy = &case.hierarchy;
        // Links are refined again and again, and elements numbered anew each time.
        let solution = case.solve(&case.fallback(), &links_only(options(Strategy::Adaptive)));
        let forest = &solution.forest;
        cells |= has_divided_cells(forest);
        for leaf in forest.leaves() {
            let leaf = leaf as u32;
            let side = forest.side_of(leaf);
            let piece = forest.piece(hierarchy, leaf);
            let above: Vec<Piece> =
                forest.above(leaf).map(|element| forest.piece(hierarchy, element)).collect();
            backs += usize::from(piece.side.back);
            deepest = deepest.max(above.len());
            let middle = piece.polygon.center();
            let corners = piece.polygon.vertices().iter();
            for point in corners.flat_map(|corner| INWARDS.map(|share| corner.lerp(middle, share))) {
                let found = forest.leaf_at(hierarchy, piece.side, point).expect("a side that takes part");
                assert_eq!((found.side, found.id), (side, leaf), "{name}: {point}");
                assert_eq!(forest.leaf_on(hierarchy, side, point).id, leaf, "{name}: {point}");
                for larger in &above {
                    assert_eq!(forest.element_in(larger, point, |_| false), leaf, "{name}: {point}");
                    assert_eq!(forest.element_in(larger, point, |id| id == larger.id), larger.id, "{name}");
                }
            }
        }
    }
    assert!(backs > 100 && cells && deepest > 5, "{backs} on backs, cells: {cells}, {deepest} deep");
}
