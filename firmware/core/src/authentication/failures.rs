//! What was refused, and when that is an alarm. Neither an alarm nor a count changes what is taken.

use super::Refused;

/// What an end has refused since its start; every count saturates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Failures {
    /// Neither sealed frames nor hellos, and kinds of frame that the end does not take.
    pub strange: u32,
    /// Frames whose checksum does not fit.
    pub damaged: u32,
    /// Sealed frames while there was no session.
    pub no_session: u32,
    /// Frames and hellos whose tag does not fit.
    pub forged: u32,
    /// Frames that were taken before, and gains that are not new.
    pub repeated: u32,
}

impl Failures {
    /// All of them.
    pub fn all(&self) -> u32 {
        let Self { strange, damaged, no_session, forged, repeated } = *self;
        [damaged, no_session, forged, repeated].into_iter().fold(strange, u32::saturating_add)
    }
}

/// What has come too often.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Alarm {
    /// Tags that do not fit: somebody writes who has no key, or the peer has lost its session.
    Forged,
    /// Frames that were taken before: somebody repeats what was recorded, or the network duplicates frames.
    Repeated,
}

/// When there is an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AlarmSettings {
    /// So many refused frames of a kind make one.
    pub most: u16,
    /// Within so many cycles.
    pub cycles: u16,
}

impl Default for AlarmSettings {
    /// Ten within a hundred cycles.
    fn default() -> Self {
        Self { most: 10, cycles: 100 }
    }
}

/// Counts, and those of the cycles that have just passed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Watch {
    settings: AlarmSettings,
    total: Failures,
    /// Cycles of the window that is under way.
    cycle: u16,
    /// Forged and repeated in this window and in the one before.
    recent: [[u16; 2]; 2],
}

impl Watch {
    pub(super) fn new(settings: AlarmSettings) -> Self {
        Self { settings, total: Failures::default(), cycle: 0, recent: [[0; 2]; 2] }
    }

    pub(super) fn total(&self) -> Failures {
        self.total
    }

    pub(super) fn cycle(&mut self) {
        self.cycle += 1;
        if self.cycle >= self.settings.cycles {
            self.cycle = 0;
            self.recent = [[0; 2], self.recent[0]];
        }
    }

    pub(super) fn count(&mut self, refused: Refused) {
        let total = &mut self.total;
        let (counter, recent) = match refused {
            Refused::Form | Refused::Kind => (&mut total.strange, None),
            Refused::Damaged => (&mut total.damaged, None),
            Refused::NoSession => (&mut total.no_session, None),
            Refused::Forged => (&mut total.forged, Some(0)),
            Refused::Repeated | Refused::Version => (&mut total.repeated, Some(1)),
        };
        *counter = counter.saturating_add(1);
        if let Some(recent) = recent.and_then(|index| self.recent[0].get_mut(index)) {
            *recent = recent.saturating_add(1);
        }
    }

    /// What came too often in this window or in the one before.
    pub(super) fn alarm(&self) -> Option<Alarm> {
        let is_over = |index: usize| self.recent.iter().any(|window| window[index] >= self.settings.most);
        if is_over(0) { Some(Alarm::Forged) } else { is_over(1).then_some(Alarm::Repeated) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alarm_comes_with_so_many_in_a_window_and_goes_once_a_window_has_passed() {
        let mut watch = Watch::new(AlarmSettings { most: 3, cycles: 10 });
        for _ in 0..2 {
            watch.count(Refused::Forged);
        }
        assert_eq!(watch.alarm(), None);
        watch.count(Refused::Forged);
        assert_eq!(watch.alarm(), Some(Alarm::Forged));
        (0..19).for_each(|_| watch.cycle());
        assert_eq!(watch.alarm(), Some(Alarm::Forged));
        watch.cycle();
        assert_eq!(watch.alarm(), None);
        assert_eq!(watch.total().forged, 3, "counted all the same");
    }

    #[test]
    fn damage_is_no_alarm_and_repetitions_are_one_of_their_own() {
        let mut watch = Watch::new(AlarmSettings { most: 2, cycles: 10 });
        for _ in 0..5 {
            watch.count(Refused::Damaged);
            watch.count(Refused::NoSession);
        }
        assert_eq!(watch.alarm(), None);
        watch.count(Refused::Repeated);
        watch.count(Refused::Version);
        assert_eq!(watch.alarm(), Some(Alarm::Repeated));
    }
}
