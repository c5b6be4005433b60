//! What the innermost steps cost, on an office of four rooms (about 27 thousand triangles):
//! `cargo bench --bench kernels`, or `cargo bench --bench kernels -- packets` for one group. Compare figures
//! of one run with each other, not with those of another machine or day.

use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

use criterion::{BatchSize, Criterion, Throughput};
use glam::DVec3;
use lightshaft::hierarchy::{Hierarchy, TOLERANCE};
use lightshaft::math::{Aabb, Clip, MAX_VERTICES, PairSequence, Plane, Polygon};
use lightshaft::progress::Silent;
use lightshaft::radiosity::{self, PolygonSource, Record, Solution, SolveOptions};
use lightshaft::scene::{self, OfficeOptions, Scene, generate_office};
use lightshaft::shaft::{End, Shaft, blocks_all, blocks_together, large_facets_on};
use lightshaft::tracer::embree::{EmbreeLibrary, EmbreeOptions, EmbreeTracer};
use lightshaft::tracer::{Candidates, FallbackTracer, FilterAudit, NO_FACET, PACKET, Segment, Tracer};
use lightshaft::visibility::{Strategy, VisibilityOptions};

/// Pairs that each step is repeated over.
const PAIRS: usize = 512;

/// One side of a facet.
struct Side {
    polygon: Polygon,
    plane: Plane,
    facet: u32,
}

impl Side {
    fn end(&self) -> End<'_> {
        End::Polygon(&self.polygon, self.plane)
    }

    fn bounds(&self, hierarchy: &Hierarchy) -> Aabb {
        hierarchy.nodes[hierarchy.leaf(self.facet) as usize].bounds
    }
}

/// The scene, and pairs of sides in it that face each other.
struct Office {
    scene: Scene,
    hierarchy: Hierarchy,
    pairs: Vec<[Side; 2]>,
}

impl Office {
    fn new() -> Office {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let options = OfficeOptions { floors: 1, rooms: 4, seed: 1 };
        let summary = generate_office(&options, folder.path()).expect("an office");
        let scene = scene::load(Path::new(&summary.scene), &Default::default(), &Silent).expect("it loads");
        let hierarchy = Hierarchy::build(&scene, false, &Silent);
        let facets = hierarchy.facets.len() as f64;
        let sequence = PairSequence::new(1);
        let side = |share: f64, back: f64| {
            let facet = (share * facets) as u32;
            let (polygon, plane) = (hierarchy.polygon(facet), hierarchy.facets[facet as usize].plane);
            match back < 0.5 {
                true => Side { polygon: polygon.flipped(), plane: plane.flipped(), facet },
                false => Side { polygon, plane, facet },
            }
        };
        let pairs = (0..)
            .map(|index| {
                let [a, b, c, d] = sequence.point(index);
                [side(a, b), side(c, d)]
            })
            .filter(|[r, s]| {
                r.plane.distance(s.polygon.center()) > 0.05 && s.plane.distance(r.polygon.center()) > 0.05
            })
            .take(PAIRS)
            .collect();
        Office { scene, hierarchy, pairs }
    }

    /// Packets of rays between the sides of each pair.
    fn packets(&self) -> Vec<Vec<Segment>> {
        let packet = |(index, [receiver, source]): (usize, &[Side; 2])| {
            let sequence = PairSequence::new(index as u64);
            let ray = |i| {
                let [a, b, c, d] = sequence.point(i);
                Segment {
                    from: receiver.polygon.point_at(a, b).as_vec3(),
                    to: source.polygon.point_at(c, d).as_vec3(),
                    skip: [receiver.facet, source.facet],
                }
            };
            (0..PACKET as u32).map(ray).collect()
        };
        self.pairs.iter().enumerate().map(packet).collect()
    }

    fn solve(&self, tracer: &dyn Tracer) -> Solution {
        let options = SolveOptions {
            epsilon: 5e-3,
            contrast: 0.4,
            min_size: None,
            resolution: 48.0,
            iterations: 20,
            visibility: VisibilityOptions { strategy: Strategy::Adaptive, rays: 4, certify: false },
            record: Record::Nothing,
        };
        let square_meters = self.hierarchy.square_meters_per_unit(self.scene.meters_per_unit);
        radiosity::solve(&self.hierarchy, tracer, &options, square_meters, &Silent)
    }
}

fn shafts(criterion: &mut Criterion, office: &Office) {
    let hierarchy = &office.hierarchy;
    let mut group = criterion.benchmark_group("shafts");
    group.throughput(Throughput::Elements(PAIRS as u64));
    group.bench_function("between polygons", |bencher| {
        bencher.iter(|| {
            office.pairs.iter().for_each(|[r, s]| {
                black_box(Shaft::between(r.end(), s.end()));
            });
        });
    });
    group.bench_function("between boxes", |bencher| {
        bencher.iter(|| {
            office.pairs.iter().for_each(|[r, s]| {
                black_box(Shaft::between(End::Box(r.bounds(hierarchy)), End::Box(s.bounds(hierarchy))));
            });
        });
    });
    let shafts: Vec<Shaft> = office.pairs.iter().map(|[r, s]| Shaft::between(r.end(), s.end())).collect();
    group.bench_function("a node against a shaft", |bencher| {
        let nodes = &hierarchy.nodes;
        bencher.iter(|| {
            for (index, shaft) in shafts.iter().enumerate() {
                black_box(shaft.place(&nodes[index % nodes.len()].bounds));
            }
        });
    });
    group.bench_function("a facet against a shaft", |bencher| {
        bencher.iter(|| {
            for (index, shaft) in shafts.iter().enumerate() {
                let facet = &office.pairs[(index * 7) % PAIRS][0].polygon;
                black_box(shaft.holds_part_of(facet.vertices(), TOLERANCE));
            }
        });
    });
    group.bench_function("cull from the root", |bencher| {
        let mut left = Vec::new();
        bencher.iter(|| {
            for shaft in &shafts {
                left.clear();
                black_box(shaft.cull(hierarchy, &[0], u64::MAX, &mut left));
            }
        });
    });
    group.bench_function("clip by a plane", |bencher| {
        bencher.iter_batched_ref(
            || {
                office
                    .pairs
                    .iter()
                    .map(|[r, _]| Clip::<{ MAX_VERTICES + 1 }>::new(r.polygon.vertices()))
                    .collect::<Vec<_>>()
            },
            |pieces| {
                for (piece, [r, s]) in pieces.iter_mut().zip(&office.pairs) {
                    let plane = Plane::through(r.polygon.center(), s.plane.normal);
                    black_box(piece.keep_front(&plane, 0.0));
                }
            },
            BatchSize::SmallInput,
        );
    });
    group.finish();
}

fn blockers(criterion: &mut Criterion, office: &Office) {
    let hierarchy = &office.hierarchy;
    let middles = |[r, s]: &[Side; 2]| [r.polygon.center(), s.polygon.center()];
    let mut group = criterion.benchmark_group("blockers");
    group.throughput(Throughput::Elements(PAIRS as u64));
    group.bench_function("search between the middles", |bencher| {
        bencher.iter(|| {
            office.pairs.iter().for_each(|pair| {
                black_box(large_facets_on(hierarchy, middles(pair), 0.02));
            });
        });
    });
    // Each pair with the largest facet between its middles, if there is one.
    let largest = office.pairs.iter().filter_map(|pair| {
        let (found, count) = large_facets_on(hierarchy, middles(pair), 0.02);
        found[..count].first().map(|&facet| (pair, facet))
    });
    let asked: Vec<(&[Side; 2], u32)> = largest.collect();
    group.throughput(Throughput::Elements(asked.len() as u64));
    group.bench_function("one facet", |bencher| {
        bencher.iter(|| {
            for ([r, s], facet) in &asked {
                let plane = &hierarchy.facets[*facet as usize].plane;
                let polygon = hierarchy.polygon(*facet);
                black_box(blocks_all(&polygon, plane, r.polygon.vertices(), s.polygon.vertices()));
            }
        });
    });
    group.bench_function("all facets of a plane", |bencher| {
        bencher.iter(|| {
            for ([r, s], facet) in &asked {
                let (a, b) = (r.polygon.vertices(), s.polygon.vertices());
                black_box(blocks_together(hierarchy, *facet, a, b));
            }
        });
    });
    group.finish();
}

/// The same rays by Embree alone, by Embree with the candidate filter, and by the tracer in Rust. They start
/// and end on surfaces; most are blocked.
fn packets(
    criterion: &mut Criterion,
    office: &Office,
    embree: Option<&EmbreeTracer>,
    fallback: &FallbackTracer,
) {
    let packets = office.packets();
    let mut group = criterion.benchmark_group("packets");
    group.throughput(Throughput::Elements((PAIRS * PACKET) as u64));
    if let Some(embree) = embree {
        group.bench_function("bare Embree", |bencher| {
            bencher.iter(|| {
                for packet in &packets {
                    black_box(embree.blocked_without_filter(packet));
                }
            });
        });
    }
    let tracers = [embree.map(|tracer| tracer as &dyn Tracer), Some(fallback)];
    for tracer in tracers.into_iter().flatten() {
        group.bench_function(format!("{}, filtered", tracer.name()), |bencher| {
            let (mut found, mut audit) = ([NO_FACET; PACKET], FilterAudit::default());
            bencher.iter(|| {
                for packet in &packets {
                    tracer.blockers(packet, Candidates::All, &mut found, &mut audit);
                    black_box(&found);
                }
            });
        });
    }
    group.finish();
}

fn light(criterion: &mut Criterion, office: &Office, tracer: &dyn Tracer) {
    let mut group = criterion.benchmark_group("light");
    group.throughput(Throughput::Elements(PAIRS as u64));
    group.bench_function("form factor of a point and a polygon", |bencher| {
        bencher.iter(|| {
            for [r, s] in &office.pairs {
                let point: DVec3 = r.polygon.center();
                black_box(PolygonSource::new(&s.polygon, s.plane).form_factor(point, r.plane.normal));
            }
        });
    });
    let solution = office.solve(tracer);
    group.throughput(Throughput::Elements(solution.links.links.len() as u64));
    group.bench_function("gather and push-pull, per link", |bencher| {
        bencher.iter(|| black_box(solution.after_one_more_bounce(&office.hierarchy)));
    });
    group.finish();
}

fn kernels(criterion: &mut Criterion) {
    let office = Office::new();
    let library = EmbreeLibrary::find(None);
    let embree = library.ok().and_then(|library| {
        EmbreeTracer::new(&library, &office.hierarchy.mesh, EmbreeOptions::default()).ok()
    });
    if embree.is_none() {
        eprintln!("no usable Embree: its benchmarks are left out");
    }
    shafts(criterion, &office);
    blockers(criterion, &office);
    let fallback = FallbackTracer::new(&office.hierarchy.mesh);
    packets(criterion, &office, embree.as_ref(), &fallback);
    light(criterion, &office, embree.as_ref().map_or(&fallback as &dyn Tracer, |tracer| tracer));
}

fn main() {
    let (warm_up, measurement) = (Duration::from_millis(500), Duration::from_secs(3));
    let criterion = Criterion::default().warm_up_time(warm_up).measurement_time(measurement);
    let mut criterion = criterion.configure_from_args();
    kernels(&mut criterion);
    criterion.final_summary();
}
