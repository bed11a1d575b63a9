//! Lists of millions of items that are kept in less room than the items take.
//!
//! What most items have in common is not kept with each of them; an item is put together whenever it is read. How that is
//! done says [`Keep`], one for each kind of item; what every list can do says [`Compact`].

use std::fmt;
use std::ops::{Deref, DerefMut, Range};

/// How items are kept.
pub trait Keep {
    /// What is put together.
    type Item;

    /// How many there are.
    fn count(&self) -> usize;

    /// The item with this index. Panics beyond the end.
    fn at(&self, index: usize) -> Self::Item;

    /// Adds an item at the end.
    fn push(&mut self, item: Self::Item);

    /// Makes room for about so many more.
    fn reserve(&mut self, additional: usize);
}

/// A list of items, kept as `K` says.
#[derive(Clone, Default)]
pub struct Compact<K> {
    kept: K,
}

impl<K: Keep> Compact<K> {
    /// How many there are.
    #[inline]
    pub fn len(&self) -> usize {
        self.kept.count()
    }

    /// Whether there are none.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The item with this index. Panics beyond the end.
    #[inline]
    pub fn at(&self, index: usize) -> K::Item {
        self.kept.at(index)
    }

    /// The item with this index; none beyond the end.
    #[inline]
    pub fn get(&self, index: usize) -> Option<K::Item> {
        (index < self.len()).then(|| self.at(index))
    }

    /// The first item.
    #[inline]
    pub fn first(&self) -> Option<K::Item> {
        self.get(0)
    }

    /// The last item.
    #[inline]
    pub fn last(&self) -> Option<K::Item> {
        self.len().checked_sub(1).map(|last| self.at(last))
    }

    /// All items in order.
    #[inline]
    pub fn iter(&self) -> Iter<'_, K> {
        self.range(0..self.len())
    }

    /// The items with these indices, in order. Panics beyond the end.
    #[inline]
    pub fn range(&self, range: Range<usize>) -> Iter<'_, K> {
        assert!(range.start <= range.end && range.end <= self.len(), "{range:?} of {}", self.len());
        Iter { kept: &self.kept, left: range }
    }

    /// Adds an item at the end.
    #[inline]
    pub fn push(&mut self, item: K::Item) {
        self.kept.push(item);
    }
}

/// What one kind of list can do besides.
impl<K> Deref for Compact<K> {
    type Target = K;

    #[inline]
    fn deref(&self) -> &K {
        &self.kept
    }
}

impl<K> DerefMut for Compact<K> {
    #[inline]
    fn deref_mut(&mut self) -> &mut K {
        &mut self.kept
    }
}

impl<K: Keep> Extend<K::Item> for Compact<K> {
    fn extend<T: IntoIterator<Item = K::Item>>(&mut self, items: T) {
        let items = items.into_iter();
        self.kept.reserve(items.size_hint().0);
        items.for_each(|item| self.push(item));
    }
}

impl<K: Keep + Default> FromIterator<K::Item> for Compact<K> {
    fn from_iter<T: IntoIterator<Item = K::Item>>(items: T) -> Compact<K> {
        let mut all: Compact<K> = Compact::default();
        all.extend(items);
        all
    }
}

impl<K: Keep<Item: PartialEq>> PartialEq for Compact<K> {
    fn eq(&self, other: &Compact<K>) -> bool {
        self.iter().eq(other)
    }
}

impl<K: Keep<Item: fmt::Debug>> fmt::Debug for Compact<K> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_list().entries(self).finish()
    }
}

impl<'a, K: Keep> IntoIterator for &'a Compact<K> {
    type Item = K::Item;
    type IntoIter = Iter<'a, K>;

    #[inline]
    fn into_iter(self) -> Iter<'a, K> {
        self.iter()
    }
}

/// Items that follow one another.
pub struct Iter<'a, K> {
    kept: &'a K,
    /// The indices of those that were not handed out.
    left: Range<usize>,
}

impl<K> Clone for Iter<'_, K> {
    fn clone(&self) -> Self {
        Iter { kept: self.kept, left: self.left.clone() }
    }
}

impl<K: Keep> Iterator for Iter<'_, K> {
    type Item = K::Item;

    #[inline]
    fn next(&mut self) -> Option<K::Item> {
        self.left.next().map(|index| self.kept.at(index))
    }

    #[inline]
    fn size_hint(&self) -> (usize, Option<usize>) {
        self.left.size_hint()
    }

    /// Without putting together those that are passed over.
    #[inline]
    fn nth(&mut self, count: usize) -> Option<K::Item> {
        self.left.nth(count).map(|index| self.kept.at(index))
    }
}

impl<K: Keep> DoubleEndedIterator for Iter<'_, K> {
    #[inline]
    fn next_back(&mut self) -> Option<K::Item> {
        self.left.next_back().map(|index| self.kept.at(index))
    }
}

impl<K: Keep> ExactSizeIterator for Iter<'_, K> {}
