//! Random order.

use crate::dice::Dice;

/// Puts `items` in random order.
pub(crate) fn shuffle<I>(dice: &mut Dice, items: &mut [I]) {
    for last in (1..items.len()).rev() {
        items.swap(last, (dice.roll() * (last + 1) as f64) as usize);
    }
}
