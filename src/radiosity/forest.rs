//! All elements: a tree for each side of each facet, numbered in depth-first order.

use super::cuts::Cuts;
use super::lines::{Lines, flat};
use super::reflectance::{Means, Measuring, Reflectance};
use super::splits::Splits;
use crate::hierarchy::{Hierarchy, Side};
use crate::math::{Plane, Polygon, hash_pair};
use crate::tracer::{Hit, Ray};
use glam::{DVec2, DVec3, Vec3};

/// The elements of all sides, and their numbering.
///
/// Element ids run through the sides in order, and through each tree in depth-first order: the first
/// half of element `e` is `e + 1`, the second is `second[e]`.
#[derive(Debug)]
pub struct Forest {
    sides_per_facet: u32,
    side_count: usize,
    cuts: Cuts,
    lines: Lines,
    /// First element of each side, with the total number at the end.
    pub first_element: Vec<u32>,
    /// First element of the cell each element belongs to: of its side, or of the part of it between the
    /// lines it is cut along. An element of several cells has itself.
    pub cell: Vec<u32>,
    /// Second half of each element, 0 for a leaf.
    pub second: Vec<u32>,
    /// Area of each element, local units.
    pub area: Vec<f32>,
    /// Centre of each element, local coordinates.
    pub center: Vec<Vec3>,
    means: Means,
    /// What was divided since.
    splits: Splits,
}

/// An element with its geometry.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Holds until elements are numbered anew.
    pub id: u32,
    /// Outline, counter-clockwise from the lit side.
    pub polygon: Polygon,
    /// Plane; the front is the lit side.
    pub plane: Plane,
    /// The side it belongs to.
    pub side: Side,
    /// Names the piece by its way from the root, whatever its id is at the moment.
    pub key: u64,
    /// How it is divided.
    cut: u32,
    /// Its line among those of the forest, if it was divided at the last numbering.
    line: u32,
    /// See [`Forest::cell`].
    pub(super) cell: u32,
}

/// A leaf element, without its geometry.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    /// The number of its side.
    pub side: usize,
    /// Its id.
    pub id: u32,
}

impl Piece {
    /// Both halves; it is divided if need be.
    pub fn halves(&self, forest: &Forest) -> [Piece; 2] {
        [0, 1].map(|half| {
            let mut part = self.clone();
            part.keep_half(forest, half);
            part
        })
    }

    /// A part of it, which is no element: with this outline, and otherwise like the whole.
    pub fn part(&self, polygon: Polygon) -> Piece {
        Piece { polygon, ..self.clone() }
    }

    /// Becomes one of its halves; it is divided if need be.
    fn keep_half(&mut self, forest: &Forest, half: usize) {
        if let Some(second) = forest.second_of(self.id) {
            self.line = line_below(self.line, self.id, second, half);
        }
        let below = forest.cuts.keep_part(&mut self.polygon, self.cut, self.side.back, half);
        self.id = forest.split(self.id)[half];
        self.key = hash_pair(self.key, half as u64 + 1);
        if forest.cuts.is_between_cells(self.cut) {
            self.cell = self.id;
        }
        self.cut = below;
    }

    /// The outlines of the halves of both halves, depth-first.
    pub fn quarters(&self, forest: &Forest) -> [Polygon; 4] {
        [0, 1, 2, 3].map(|quarter| {
            let mut outline = self.polygon;
            let cut = forest.cuts.keep_part(&mut outline, self.cut, self.side.back, quarter / 2);
            forest.cuts.keep_part(&mut outline, cut, self.side.back, quarter % 2);
            outline
        })
    }
}

/// Finds one element after the other: those of a side in ascending order cost little, since what is above both of
/// two is gone down once.
pub struct Way<'a> {
    hierarchy: &'a Hierarchy,
    forest: &'a Forest,
    /// The elements above the last one and itself, each with the first id that is no longer below it.
    pieces: Vec<(Piece, u32)>,
}

impl<'a> Way<'a> {
    /// Nothing is found yet.
    pub fn new(hierarchy: &'a Hierarchy, forest: &'a Forest) -> Way<'a> {
        Way { hierarchy, forest, pieces: Vec::new() }
    }

    /// An element with its geometry.
    pub fn to(&mut self, element: u32) -> &Piece {
        while self.pieces.pop_if(|(piece, end)| element < piece.id || element >= *end).is_some() {}
        if self.pieces.is_empty() {
            let side = self.forest.side_of(element);
            self.pieces.push((self.forest.root(self.hierarchy, side), self.forest.first_element[side + 1]));
        }
        loop {
            let (piece, end) = &self.pieces[self.pieces.len() - 1];
            if piece.id == element {
                break;
            }
            let second = self.forest.second[piece.id as usize];
            let (half, end) = if element < second { (0, second) } else { (1, *end) };
            let mut below = piece.clone();
            below.keep_half(self.forest, half);
            self.pieces.push((below, end));
        }
        &self.pieces[self.pieces.len() - 1].0
    }
}

/// The line of a half of the element with this id and this line. Below its first half there are as many lines as that has
/// elements, less one, halved.
fn line_below(line: u32, id: u32, second: u32, half: usize) -> u32 {
    if half == 0 { line + 1 } else { line + (second - id) / 2 }
}

/// Puts what `is_first` holds for before the rest, and says how many that are.
fn parted<T>(items: &mut [T], is_first: impl Fn(&T) -> bool) -> usize {
    let mut count = 0;
    for i in 0..items.len() {
        if is_first(&items[i]) {
            items.swap(count, i);
            count += 1;
        }
    }
    count
}

/// No element of a restored forest lies further down than this. Longest-edge bisection takes an element from the size
/// of the scene to the smallest there is in some 40 steps, and [`Cuts`] are 20 deep.
const DEEPEST: u32 = 128;

impl Forest {
    /// One element for each side, or as many as the lines make where other surfaces stand on it or cover it.
    pub fn new(hierarchy: &Hierarchy) -> Forest {
        let mut forest = Forest::undivided(hierarchy);
        for side in 0..forest.side_count {
            let mut stack = vec![forest.root(hierarchy, side)];
            while let Some(piece) = stack.pop() {
                if forest.cuts.is_between_cells(piece.cut) {
                    stack.extend(piece.halves(&forest));
                }
            }
        }
        forest.renumber(hierarchy);
        forest
    }

    /// Elements of which it is known, in the order of their ids, which are split; `None` when that makes no forest of
    /// this hierarchy, or one that no solver would make.
    pub fn from_splits(hierarchy: &Hierarchy, is_split: &[bool]) -> Option<Forest> {
        let mut forest = Forest::undivided(hierarchy);
        let mut is_split = is_split.iter();
        let mut stack = Vec::new();
        for root in 0..forest.side_count as u32 {
            stack.push((root, 0));
            while let Some((element, depth)) = stack.pop() {
                if *is_split.next()? {
                    if depth == DEEPEST {
                        return None;
                    }
                    let [a, b] = forest.split(element);
                    stack.extend([(b, depth + 1), (a, depth + 1)]);
                }
            }
        }
        if is_split.next().is_some() {
            return None;
        }
        forest.renumber(hierarchy);
        Some(forest)
    }

    /// The same elements in a forest of its own, but for those leaves, by their order, that `is_divided` says: they are
    /// divided in four. Of leaves that it does not reach none is.
    pub fn divided(&self, hierarchy: &Hierarchy, is_divided: &[bool]) -> Forest {
        let mut forest = Forest::undivided(hierarchy);
        let mut is_divided = is_divided.iter();
        let mut stack = Vec::new();
        for side in 0..self.side_count {
            stack.push((self.first_element[side], side as u32));
            while let Some((old, new)) = stack.pop() {
                let second = self.second[old as usize];
                if second != 0 {
                    let [a, b] = forest.split(new);
                    stack.extend([(second, b), (old + 1, a)]);
                } else if is_divided.next() == Some(&true) {
                    for half in forest.split(new) {
                        forest.split(half);
                    }
                }
            }
        }
        forest.renumber(hierarchy);
        forest
    }

    /// Whether what an element is divided into in four lies no deeper than [`Forest::from_splits`] takes.
    pub fn may_be_divided(&self, element: u32) -> bool {
        self.above(element).count() + 2 <= DEEPEST as usize
    }

    /// One element for each side, not numbered yet.
    fn undivided(hierarchy: &Hierarchy) -> Forest {
        let count = hierarchy.facets.len() as u32 * hierarchy.sides();
        Forest {
            sides_per_facet: hierarchy.sides(),
            side_count: count as usize,
            cuts: Cuts::of(hierarchy),
            lines: Lines::default(),
            first_element: Vec::new(),
            cell: Vec::new(),
            second: Vec::new(),
            area: Vec::new(),
            center: Vec::new(),
            means: Means::default(),
            splits: Splits::new(count),
        }
    }

    /// Bytes that their numbering takes.
    pub(super) fn bytes(&self) -> u64 {
        let Forest { first_element, cell, second, area, center, .. } = self;
        let by_element = size_of_val(&cell[..]) + size_of_val(&second[..]) + size_of_val(&area[..]);
        (size_of_val(&first_element[..]) + by_element + size_of_val(&center[..])) as u64 + self.lines.bytes()
    }

    /// Number of elements at the last numbering.
    pub fn len(&self) -> usize {
        self.second.len()
    }

    /// Elements that are not split.
    pub fn leaves(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(|&element| self.second[element] == 0)
    }

    /// Those of one side.
    pub fn leaves_of(&self, index: usize) -> impl Iterator<Item = usize> + '_ {
        self.elements_of(index).filter(|&element| self.second[element] == 0)
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.second.is_empty()
    }

    /// Number of sides.
    pub fn side_count(&self) -> usize {
        self.side_count
    }

    /// The side with this number.
    pub fn side(&self, index: usize) -> Side {
        let index = index as u32;
        Side { facet: index / self.sides_per_facet, back: index % self.sides_per_facet == 1 }
    }

    /// The number of a side, if it takes part.
    pub fn side_index(&self, side: Side) -> Option<usize> {
        (!side.back || self.sides_per_facet == 2)
            .then_some((side.facet * self.sides_per_facet + u32::from(side.back)) as usize)
    }

    /// The numbers of the sides of a facet.
    pub fn sides_of(&self, facet: u32) -> std::ops::Range<usize> {
        let first = (facet * self.sides_per_facet) as usize;
        first..first + self.sides_per_facet as usize
    }

    /// The elements of a side: the undivided one first.
    pub fn elements_of(&self, index: usize) -> std::ops::Range<usize> {
        self.first_element[index] as usize..self.first_element[index + 1] as usize
    }

    /// What the elements of a side reflect.
    pub fn reflectance(&self, hierarchy: &Hierarchy, index: usize) -> Reflectance<'_> {
        match self.means.of_side(index) {
            Some(means) => Reflectance::Painted { first: self.first_element[index], means },
            None => Reflectance::Even(Vec3::from(hierarchy.material(self.side(index).facet).reflectance)),
        }
    }

    /// What a leaf element reflects.
    pub fn reflectance_of(&self, hierarchy: &Hierarchy, leaf: Leaf) -> Vec3 {
        self.reflectance(hierarchy, leaf.side).of(leaf.id)
    }

    /// Takes what elements reflect from a hierarchy that has other materials than the one before.
    pub(super) fn change_materials(&mut self, hierarchy: &Hierarchy) {
        self.means = Means::default();
        self.renumber(hierarchy);
    }

    /// The mean of a picture over an element that was a leaf at the last numbering.
    fn mean_before(&self, index: usize, element: u32) -> Option<Vec3> {
        let means = self.means.of_side(index)?;
        let is_known = self.second.get(element as usize) == Some(&0);
        is_known.then(|| means[(element - self.first_element[index]) as usize])
    }

    /// The undivided element of a side.
    pub fn root(&self, hierarchy: &Hierarchy, index: usize) -> Piece {
        let side = self.side(index);
        let polygon = hierarchy.side_polygon(side);
        let plane = hierarchy.facets[side.facet as usize].plane;
        let plane = if side.back { plane.flipped() } else { plane };
        let cut = self.cuts.first(side.facet);
        let id = self.root_id(index);
        let line = self.first_line(index);
        Piece { id, polygon, plane, side, key: hash_pair(index as u64, 0), cut, line, cell: id }
    }

    /// The id of the undivided element of a side; before elements are numbered for the first time that of the side.
    fn root_id(&self, index: usize) -> u32 {
        self.first_element.get(index).copied().unwrap_or(index as u32)
    }

    /// The line of the undivided element of a side: those before it have as many lines as they have halves.
    fn first_line(&self, index: usize) -> u32 {
        self.first_element.get(index).map_or(0, |first| (first - index as u32) / 2)
    }

    /// The second half of an element that was divided at the last numbering.
    fn second_of(&self, id: u32) -> Option<u32> {
        self.second.get(id as usize).copied().filter(|&second| second != 0)
    }

    /// Both halves of an element, which is divided if need be.
    fn split(&self, id: u32) -> [u32; 2] {
        self.second_of(id).map_or_else(|| self.splits.split(id), |second| [id + 1, second])
    }

    /// Both halves of an element, if it is divided.
    fn halves_of(&self, id: u32) -> Option<[u32; 2]> {
        self.second_of(id).map(|second| [id + 1, second]).or_else(|| self.splits.halves(id))
    }

    /// The number of the side an element belongs to.
    pub fn side_of(&self, element: u32) -> usize {
        self.first_element.partition_point(|&first| first <= element) - 1
    }

    /// The elements that one is a part of, from the undivided side down.
    pub fn above(&self, element: u32) -> impl Iterator<Item = u32> + '_ {
        let root = self.first_element[self.side_of(element)];
        let below = move |&at: &u32| {
            let second = self.second[at as usize];
            Some(if element < second { at + 1 } else { second })
        };
        std::iter::successors(Some(root), below).take_while(move |&at| at != element)
    }

    /// An element with its geometry, found from the root of its side.
    pub fn piece(&self, hierarchy: &Hierarchy, element: u32) -> Piece {
        let mut piece = self.root(hierarchy, self.side_of(element));
        while piece.id != element {
            let half = usize::from(element >= self.second[piece.id as usize]);
            piece.keep_half(self, half);
        }
        piece
    }

    /// Visits every element, inner and leaf, with its geometry.
    pub fn for_each_element(&self, hierarchy: &Hierarchy, mut visit: impl FnMut(&Piece)) {
        for side in 0..self.side_count() {
            let mut stack = vec![self.root(hierarchy, side)];
            while let Some(piece) = stack.pop() {
                visit(&piece);
                if self.second[piece.id as usize] != 0 {
                    stack.extend(piece.halves(self));
                }
            }
        }
    }

    /// The elements at a flat point, from the one with this id and this line down to the leaf.
    fn elements_at(&self, id: u32, line: u32, point: DVec2) -> impl Iterator<Item = u32> + '_ {
        let below = move |&(id, line): &(u32, u32)| {
            let second = self.second_of(id)?;
            let half = self.lines.half(line, point);
            Some(([id + 1, second][half], line_below(line, id, second, half)))
        };
        std::iter::successors(Some((id, line)), below).map(|(id, _)| id)
    }

    /// The ids of the elements at a point of an element, from its own down to the leaf.
    pub(super) fn elements_below(
        &self,
        hierarchy: &Hierarchy,
        element: u32,
        point: DVec3,
    ) -> impl Iterator<Item = u32> + '_ {
        let index = self.side_of(element);
        let (mut id, mut line) = (self.first_element[index], self.first_line(index));
        while id != element {
            let second = self.second[id as usize];
            let half = usize::from(element >= second);
            (id, line) = ([id + 1, second][half], line_below(line, id, second, half));
        }
        self.elements_at(id, line, flat(hierarchy.side_normal(self.side(index)), point))
    }

    /// The id of the element at a point of a piece: the first on the way down to its leaf that `is_enough` holds for,
    /// else the leaf.
    pub fn element_in(&self, piece: &Piece, point: DVec3, is_enough: impl Fn(u32) -> bool) -> u32 {
        let mut last = piece.id;
        for id in self.elements_at(last, piece.line, flat(piece.plane.normal, point)) {
            last = id;
            if self.second_of(id).is_none() || is_enough(id) {
                break;
            }
        }
        last
    }

    /// Visits the elements of a piece that hold some of the `points`, with those: the first on the way down to the leaf
    /// that `is_enough` holds for, else the leaf. The points are put in order for that.
    pub(super) fn visit_elements_in<T>(
        &self,
        piece: &Piece,
        points: &mut [T],
        position: &impl Fn(&T) -> DVec3,
        is_enough: &impl Fn(u32) -> bool,
        visit: &mut impl FnMut(u32, &[T]),
    ) {
        let position = |point: &T| flat(piece.plane.normal, position(point));
        self.visit_below(piece.id, piece.line, points, &position, is_enough, visit);
    }

    fn visit_below<T>(
        &self,
        id: u32,
        line: u32,
        points: &mut [T],
        position: &impl Fn(&T) -> DVec2,
        is_enough: &impl Fn(u32) -> bool,
        visit: &mut impl FnMut(u32, &[T]),
    ) {
        if points.is_empty() {
            return;
        }
        let Some(second) = self.second_of(id).filter(|_| !is_enough(id)) else {
            visit(id, points);
            return;
        };
        let in_first = parted(points, |point| self.lines.half(line, position(point)) == 0);
        let (first, rest) = points.split_at_mut(in_first);
        let [line_a, line_b] = [0, 1].map(|half| line_below(line, id, second, half));
        self.visit_below(id + 1, line_a, first, position, is_enough, visit);
        self.visit_below(second, line_b, rest, position, is_enough, visit);
    }

    /// The leaf element at a point on a side; `None` for a side that takes no part.
    pub fn leaf_at(&self, hierarchy: &Hierarchy, side: Side, point: DVec3) -> Option<Leaf> {
        let index = self.side_index(side)?;
        let root = self.first_element[index];
        let point = flat(hierarchy.side_normal(side), point);
        let id = self.elements_at(root, self.first_line(index), point).last().unwrap_or(root);
        Some(Leaf { side: index, id })
    }

    /// The leaf element at a point on the side with this number, with its geometry.
    pub fn leaf_on(&self, hierarchy: &Hierarchy, index: usize, point: DVec3) -> Piece {
        let mut piece = self.root(hierarchy, index);
        let point = flat(piece.plane.normal, point);
        while self.second[piece.id as usize] != 0 {
            let half = self.lines.half(piece.line, point);
            piece.keep_half(self, half);
        }
        piece
    }

    /// The leaf element that a ray met; `None` for a side that takes no part.
    pub fn leaf_met(&self, hierarchy: &Hierarchy, ray: &Ray, hit: &Hit) -> Option<Leaf> {
        let point = ray.origin.as_dvec3() + ray.direction.as_dvec3() * hit.t as f64;
        self.leaf_at(hierarchy, hierarchy.side_met(hit.facet, ray.direction), point)
    }

    /// Numbers all elements anew in depth-first order; returns, for each old id, the new one.
    ///
    /// The result depends on which elements exist, not on who made them first.
    pub fn renumber(&mut self, hierarchy: &Hierarchy) -> Vec<u32> {
        let total = self.splits.end() as usize;
        let mut new_from_old = vec![0; total];
        let mut first_element = Vec::with_capacity(self.side_count + 1);
        let mut cell = Vec::with_capacity(total);
        let mut second = Vec::with_capacity(total);
        let mut area = Vec::with_capacity(total);
        let mut center = Vec::with_capacity(total);
        let mut lines = Lines::with_capacity(total.saturating_sub(self.side_count) / 2);
        let mut stack = Vec::new();
        let mut measuring = Measuring::new(hierarchy);
        for index in 0..self.side_count {
            first_element.push(second.len() as u32);
            measuring.begin_side(self.side(index).facet);
            let root = self.root(hierarchy, index);
            stack.push((root.id, root.polygon, root.cut, None, None));
            while let Some((old, outline, cut, own_cell, parent)) = stack.pop() {
                let id = second.len() as u32;
                let own_cell = own_cell.unwrap_or(id);
                cell.push(own_cell);
                if let Some(parent) = parent {
                    second[parent as usize] = id;
                }
                let halves = self.halves_of(old);
                measuring.add(halves.is_none().then_some(&outline), || self.mean_before(index, old));
                new_from_old[old as usize] = id;
                second.push(0);
                area.push(outline.area() as f32);
                center.push(outline.center().as_vec3());
                if let Some([a, b]) = halves {
                    lines.push(&self.cuts.across(&outline, cut, root.plane.normal), &root.plane);
                    let below = (!self.cuts.is_between_cells(cut)).then_some(own_cell);
                    for (half, old, parent) in [(1, b, Some(id)), (0, a, None)] {
                        let mut part = outline;
                        let cut = self.cuts.keep_part(&mut part, cut, root.side.back, half);
                        stack.push((old, part, cut, below, parent));
                    }
                }
            }
        }
        first_element.push(second.len() as u32);
        debug_assert!(second.len() <= total);
        self.first_element = first_element;
        self.cell = cell;
        self.second = second;
        self.area = area;
        self.center = center;
        self.lines = lines;
        self.splits = Splits::new(self.second.len() as u32);
        self.means = measuring.finish(&self.first_element, |element| {
            let second = self.second[element as usize];
            (second != 0).then(|| [element + 1, second].map(|half| (half, self.area[half as usize])))
        });
        new_from_old
    }
}
