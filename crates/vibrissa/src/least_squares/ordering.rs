//! An order of unknowns in which those that know each other are near: reverse Cuthill-McKee \[cuthill1969reducing; george1981computer\].

/// The unknowns in an order that keeps a sparse symmetric system within a narrow band; `neighbours` of each are those that it shares a
/// residual with.
pub(crate) fn reverse_cuthill_mckee(neighbours: &[Vec<usize>]) -> Vec<usize> {
    let mut order = Vec::with_capacity(neighbours.len());
    let mut is_taken = vec![false; neighbours.len()];
    let mut by_degree: Vec<usize> = (0..neighbours.len()).collect();
    by_degree.sort_by_key(|&k| neighbours[k].len());
    for start in by_degree {
        if is_taken[start] {
            continue;
        }
        let start = peripheral(neighbours, start);
        levels(neighbours, start, &mut is_taken, &mut order);
    }
    order.reverse();
    order
}

/// An unknown from which the farthest others are far.
fn peripheral(neighbours: &[Vec<usize>], mut start: usize) -> usize {
    let mut depth = 0;
    loop {
        let mut order = Vec::new();
        let found = levels(neighbours, start, &mut vec![false; neighbours.len()], &mut order);
        if found <= depth {
            return start;
        }
        depth = found;
        // The last level's least.
        start = order.last().copied().unwrap_or(start);
    }
}

/// Goes through all that hang together with a start, by their distance, the least first; gives the largest distance.
fn levels(neighbours: &[Vec<usize>], start: usize, is_taken: &mut [bool], order: &mut Vec<usize>) -> usize {
    let (mut from, mut depth) = (order.len(), 0);
    is_taken[start] = true;
    order.push(start);
    loop {
        let to = order.len();
        for k in from..to {
            let mut next: Vec<usize> = neighbours[order[k]].iter().copied().filter(|&n| !is_taken[n]).collect();
            next.sort_by_key(|&n| neighbours[n].len());
            next.dedup();
            for n in next {
                if !is_taken[n] {
                    is_taken[n] = true;
                    order.push(n);
                }
            }
        }
        if order.len() == to {
            return depth;
        }
        (from, depth) = (to, depth + 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn width(neighbours: &[Vec<usize>], order: &[usize]) -> usize {
        let mut place = vec![0; order.len()];
        order.iter().enumerate().for_each(|(at, &k)| place[k] = at);
        let pairs = neighbours.iter().enumerate().flat_map(|(k, all)| all.iter().map(move |n| (k, *n)));
        pairs.map(|(a, b)| place[a].abs_diff(place[b])).max().unwrap_or(0)
    }

    #[test]
    fn laps_of_a_ring_stay_beside_each_other() {
        // Ten laps of forty places, each tied to the same place of the lap before: a band of two laps' worth of places across the ring.
        let (round, laps) = (40, 10);
        let mut neighbours = vec![Vec::new(); round * laps];
        let mut tie = |a: usize, b: usize| {
            neighbours[a].push(b);
            neighbours[b].push(a);
        };
        for k in 1..round * laps {
            tie(k - 1, k);
            if k >= round {
                tie(k - round, k);
            }
        }
        let order = reverse_cuthill_mckee(&neighbours);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..round * laps).collect::<Vec<_>>());
        assert!(width(&neighbours, &order) <= 3 * laps, "{}", width(&neighbours, &order));
    }

    #[test]
    fn parts_that_know_nothing_of_each_other_come_one_after_the_other() {
        let neighbours = vec![vec![2], vec![3], vec![0], vec![1], vec![]];
        let order = reverse_cuthill_mckee(&neighbours);
        assert_eq!((order.len(), width(&neighbours, &order)), (5, 1));
        assert!(reverse_cuthill_mckee(&[]).is_empty());
    }
}
