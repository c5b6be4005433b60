//! Work of visibility tests by receiver, as it is done.

use super::links::renamed;

/// Receivers and work done for them, in rays.
#[derive(Debug, Default)]
pub(super) struct WorkDone(Vec<(u32, u64)>);

impl WorkDone {
    /// Some for a node, by its id as links have it.
    pub(super) fn add(&mut self, receiver: u32, work: u64) {
        match self.0.last_mut() {
            Some((last, sum)) if *last == receiver => *sum += work,
            _ => self.0.push((receiver, work)),
        }
    }

    /// Takes over what another one has.
    pub(super) fn absorb(&mut self, other: WorkDone) {
        self.0.extend(other.0);
    }

    /// One entry for a receiver from now on: there are many more pairs than receivers.
    pub(super) fn join(&mut self) {
        self.0.sort_unstable();
        self.0.dedup_by(|(later, more), (receiver, sum)| {
            let is_same = later == receiver;
            if is_same {
                *sum += *more;
            }
            is_same
        });
        self.0.shrink_to_fit();
    }

    /// Gives elements their new ids.
    pub(super) fn rename(&mut self, clusters: u32, new_from_old: &[u32]) {
        for (receiver, _) in &mut self.0 {
            *receiver = renamed(*receiver, clusters, new_from_old);
        }
    }

    /// Adds all to sums by node id; if there is none, there need be no sums.
    pub(super) fn add_to(&self, sums: &mut [u64]) {
        self.0.iter().for_each(|&(receiver, work)| sums[receiver as usize] += work);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_adds_up_whatever_the_order_and_the_names() {
        let mut done = WorkDone::default();
        for (receiver, work) in [(5, 1), (5, 2), (1, 4), (5, 8)] {
            done.add(receiver, work);
        }
        let mut other = WorkDone::default();
        other.add(1, 16);
        done.absorb(other);
        done.join();
        assert_eq!(done.0, [(1, 20), (5, 11)]);
        done.rename(4, &[3, 0]);
        let mut sums = [1; 8];
        done.add_to(&mut sums);
        assert_eq!(sums, [1, 21, 1, 1, 12, 1, 1, 1]);
    }
}
