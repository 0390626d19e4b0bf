//! Sets of token kinds.

use crate::kind::SyntaxKind;

/// A set of token kinds, as a bit set that is built at compile time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TokenSet([u64; 3]);

const _: () = assert!((SyntaxKind::TOMBSTONE as usize) < 192, "tokens fit the set");

impl TokenSet {
    /// The set of these kinds.
    pub(crate) const fn new(kinds: &[SyntaxKind]) -> TokenSet {
        let mut set = [0; 3];
        let mut i = 0;
        while i < kinds.len() {
            let bit = kinds[i] as usize;
            set[bit / 64] |= 1 << (bit % 64);
            i += 1;
        }
        TokenSet(set)
    }

    /// The kinds of both sets.
    pub(crate) const fn union(self, other: TokenSet) -> TokenSet {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        TokenSet([a | d, b | e, c | f])
    }

    pub(crate) const fn contains(&self, kind: SyntaxKind) -> bool {
        let bit = kind as usize;
        bit < 192 && self.0[bit / 64] & (1 << (bit % 64)) != 0
    }
}
