//! Lists of millions of items that take less memory than the items would side by side.
//!
//! [`Packing`] defines the layout of one item type: it leaves out what most items have in common and
//! assembles an item whenever it is read. [`PackedVec`] is the list API that all layouts share.

use std::fmt;
use std::ops::{Deref, DerefMut, Range};

/// The layout of the items of one list.
pub trait Packing {
    /// The type of the items.
    type Item;

    /// Returns the number of items.
    fn count(&self) -> usize;

    /// Returns the item at `index`.
    ///
    /// # Panics
    ///
    /// Panics if `index` is out of bounds.
    fn at(&self, index: usize) -> Self::Item;

    /// Appends an item.
    fn push(&mut self, item: Self::Item);

    /// Reserves memory for about `additional` more items.
    fn reserve(&mut self, additional: usize);
}

/// A list of items in the layout of `K`.
#[derive(Clone, Default)]
pub struct PackedVec<K> {
    kept: K,
}

impl<K: Packing> PackedVec<K> {
    /// Returns the number of items.
    #[inline]
    pub fn len(&self) -> usize {
        self.kept.count()
    }

    /// Returns `true` if the list is empty.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the item at `index`.
    ///
    /// # Panics
    ///
    /// Panics if `index` is out of bounds.
    #[inline]
    pub fn at(&self, index: usize) -> K::Item {
        self.kept.at(index)
    }

    /// Returns the item at `index`, or `None` if `index` is out of bounds.
    #[inline]
    pub fn get(&self, index: usize) -> Option<K::Item> {
        (index < self.len()).then(|| self.at(index))
    }

    /// Returns the first item, or `None` if the list is empty.
    #[inline]
    pub fn first(&self) -> Option<K::Item> {
        self.get(0)
    }

    /// Returns the last item, or `None` if the list is empty.
    #[inline]
    pub fn last(&self) -> Option<K::Item> {
        self.len().checked_sub(1).map(|last| self.at(last))
    }

    /// Returns an iterator over all items.
    #[inline]
    pub fn iter(&self) -> Iter<'_, K> {
        self.range(0..self.len())
    }

    /// Returns an iterator over the items with these indices.
    ///
    /// # Panics
    ///
    /// Panics if the range is out of bounds.
    #[inline]
    pub fn range(&self, range: Range<usize>) -> Iter<'_, K> {
        assert!(range.start <= range.end && range.end <= self.len(), "{range:?} of {}", self.len());
        Iter { kept: &self.kept, left: range }
    }

    /// Appends an item.
    #[inline]
    pub fn push(&mut self, item: K::Item) {
        self.kept.push(item);
    }
}

/// Gives access to the methods that one layout adds.
impl<K> Deref for PackedVec<K> {
    type Target = K;

    #[inline]
    fn deref(&self) -> &K {
        &self.kept
    }
}

impl<K> DerefMut for PackedVec<K> {
    #[inline]
    fn deref_mut(&mut self) -> &mut K {
        &mut self.kept
    }
}

impl<K: Packing> Extend<K::Item> for PackedVec<K> {
    fn extend<T: IntoIterator<Item = K::Item>>(&mut self, items: T) {
        let items = items.into_iter();
        self.kept.reserve(items.size_hint().0);
        items.for_each(|item| self.push(item));
    }
}

impl<K: Packing + Default> FromIterator<K::Item> for PackedVec<K> {
    fn from_iter<T: IntoIterator<Item = K::Item>>(items: T) -> PackedVec<K> {
        let mut all: PackedVec<K> = PackedVec::default();
        all.extend(items);
        all
    }
}

impl<K: Packing<Item: PartialEq>> PartialEq for PackedVec<K> {
    fn eq(&self, other: &PackedVec<K>) -> bool {
        self.iter().eq(other)
    }
}

impl<K: Packing<Item: fmt::Debug>> fmt::Debug for PackedVec<K> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.debug_list().entries(self).finish()
    }
}

impl<'a, K: Packing> IntoIterator for &'a PackedVec<K> {
    type Item = K::Item;
    type IntoIter = Iter<'a, K>;

    #[inline]
    fn into_iter(self) -> Iter<'a, K> {
        self.iter()
    }
}

/// An iterator over consecutive items.
pub struct Iter<'a, K> {
    kept: &'a K,
    /// Indices of the items that are still to come.
    left: Range<usize>,
}

impl<K> Clone for Iter<'_, K> {
    fn clone(&self) -> Self {
        Iter { kept: self.kept, left: self.left.clone() }
    }
}

impl<K: Packing> Iterator for Iter<'_, K> {
    type Item = K::Item;

    #[inline]
    fn next(&mut self) -> Option<K::Item> {
        self.left.next().map(|index| self.kept.at(index))
    }

    #[inline]
    fn size_hint(&self) -> (usize, Option<usize>) {
        self.left.size_hint()
    }

    /// Skips items without assembling them.
    #[inline]
    fn nth(&mut self, count: usize) -> Option<K::Item> {
        self.left.nth(count).map(|index| self.kept.at(index))
    }
}

impl<K: Packing> DoubleEndedIterator for Iter<'_, K> {
    #[inline]
    fn next_back(&mut self) -> Option<K::Item> {
        self.left.next_back().map(|index| self.kept.at(index))
    }
}

impl<K: Packing> ExactSizeIterator for Iter<'_, K> {}
