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

#[cfg(test)]
mod tests {
    use super::Thinned;

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
