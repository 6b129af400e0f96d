//! A record of bounded size, however long the log.

/// What is kept of a growing sequence: every item at first, then every second, every fourth, and so on.
///
/// Between `LEAST` and twice as many items are kept, evenly spread from the first on; all as long as they are fewer.
#[derive(Clone, Debug)]
pub(crate) struct Thinned<T, const LEAST: usize> {
    kept: Vec<T>,
    seen: usize,
    stride: usize,
}

impl<T, const LEAST: usize> Default for Thinned<T, LEAST> {
    fn default() -> Self {
        Self { kept: Vec::new(), seen: 0, stride: 1 }
    }
}

impl<T, const LEAST: usize> Thinned<T, LEAST> {
    /// Takes the next item of the sequence.
    pub(crate) fn push(&mut self, item: T) {
        if self.seen.is_multiple_of(self.stride) {
            self.kept.push(item);
        }
        self.seen += 1;
        if self.kept.len() >= 2 * LEAST {
            self.stride *= 2;
            let mut index = 0;
            self.kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
    }

    /// What is kept, in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        self.kept.iter()
    }
}

/// One in `every` items, the first among them, spread over all as a golden section divides a circle. What comes back every few items,
/// like the images of a symmetric map, is thinned as much as all else; every n-th item may hold none of it.
pub fn one_in<T>(items: impl IntoIterator<Item = T>, every: usize) -> impl Iterator<Item = T> {
    // The fractional part of the golden section, in parts of 2^64.
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    let share = u64::MAX / every.max(1) as u64;
    let kept = move |index: usize| (index as u64).wrapping_mul(GOLDEN) <= share;
    items.into_iter().enumerate().filter(move |(index, _)| kept(*index)).map(|(_, item)| item)
}

#[cfg(test)]
mod tests {
    use super::{Thinned, one_in};

    #[test]
    fn one_in_so_many_is_one_in_so_many_of_what_comes_back_too() {
        assert_eq!(one_in(0..5, 1).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
        for every in [2, 3, 4, 7, 8] {
            assert_eq!(one_in(0..9, every).next(), Some(0));
            for period in 1..=12 {
                for phase in 0..period {
                    let of = (0..20_000).filter(|item| item % period == phase).count();
                    let kept = one_in(0..20_000, every).filter(|item| item % period == phase).count();
                    let wanted = of as f64 / every as f64;
                    assert!(
                        (kept as f64 - wanted).abs() < 12.0,
                        "1 in {every}, {phase} of {period}: {kept} for {wanted}"
                    );
                }
            }
        }
    }

    #[test]
    fn keeps_all_of_few_and_an_even_share_of_many() {
        for count in [0, 1, 7, 8, 9, 100, 1000, 12_345] {
            let mut thinned: Thinned<usize, 4> = Thinned::default();
            (0..count).for_each(|item| thinned.push(item));
            let kept: Vec<usize> = thinned.iter().copied().collect();
            assert!(kept.len() >= count.min(4) && kept.len() < 8, "{count}: {kept:?}");
            if count < 8 {
                assert_eq!(kept, (0..count).collect::<Vec<_>>());
            }
            let step = kept.get(1).copied().unwrap_or(0);
            assert!(kept.iter().enumerate().all(|(index, &item)| item == index * step), "{count}: {kept:?}");
        }
    }
}
