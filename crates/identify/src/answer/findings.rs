//! What is found in logs before any effect is asked for: whether they are of one machine, and which samples are data.

use crate::bench::Channel;

/// Something that was found in a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Name of the log.
    pub log: String,
    /// What.
    pub about: About,
}

/// What was found in a log.
#[derive(Debug, Clone, PartialEq)]
pub enum About {
    /// A channel is another one's times a factor that it should not have.
    Scale {
        /// Which.
        channel: Channel,
        /// What it is compared with.
        against: Channel,
        /// How many times too large.
        factor: f64,
        /// What that factor would be.
        reads: Option<&'static str>,
    },
    /// A channel has the other sign than another one of the same shaft.
    Sign {
        /// Which.
        channel: Channel,
        /// What it is compared with.
        against: Channel,
    },
    /// A channel does not follow another one of the same shaft.
    Unrelated {
        /// Which.
        channel: Channel,
        /// What it is compared with.
        against: Channel,
    },
    /// The logged duty cycle is not what the declared controller asks for.
    Controller {
        /// How many times that: less than zero where the sign is another.
        factor: f64,
    },
    /// A position is late against the velocity of the same shaft; it is brought to the velocity's time.
    Late {
        /// Which.
        channel: Channel,
        /// The velocity.
        against: Channel,
        /// By how much \[s\]; less than zero where the velocity is the late one.
        lag: f64,
    },
    /// Channels repeat each value.
    Held {
        /// Which.
        channels: Vec<Channel>,
        /// How many rows there are for a fresh value.
        rows: f64,
        /// Whether all measured channels do, so that only the fresh rows are data.
        whole: bool,
    },
    /// A channel stood still while the machine moved; the stretch is left out.
    Stale {
        /// Which.
        channel: Channel,
        /// From \[s\].
        from: f64,
        /// To \[s\].
        to: f64,
    },
    /// A channel stops at a value; these samples are left out.
    Clipped {
        /// Which.
        channel: Channel,
        /// At which value, SI.
        at: f64,
        /// Share of the samples.
        share: f64,
    },
    /// Single samples far off both their neighbours were left out.
    Spikes {
        /// Which channel.
        channel: Channel,
        /// How many.
        count: usize,
    },
    /// Samples come at uneven times: steps of the shortest and the longest twentieth, and the usual one \[s\].
    Irregular {
        /// A twentieth is shorter.
        short: f64,
        /// The median.
        usual: f64,
        /// A twentieth is longer.
        long: f64,
    },
    /// Few seconds own much of the error; they are left out.
    Owns {
        /// From \[s\].
        from: f64,
        /// To \[s\].
        to: f64,
        /// Share of the squared error of all logs for fitting.
        share: f64,
    },
    /// The bench file leaves a stretch out.
    Excluded {
        /// From \[s\]; minus infinity from the beginning.
        from: f64,
        /// To \[s\]; infinity to the end.
        to: f64,
        /// How many rows of the log lie in it.
        rows: usize,
    },
    /// The zero of a sensor would be larger than anything that it read.
    Zero {
        /// Which channel.
        channel: Channel,
        /// The zero, SI.
        zero: f64,
        /// The largest value of the log in size, SI.
        most: f64,
    },
    /// The bench file says that a channel is the driver's own estimate.
    Estimated(Channel),
}

impl About {
    /// Its name, also in JSON.
    pub fn name(&self) -> &'static str {
        match self {
            About::Scale { .. } => "scale",
            About::Sign { .. } => "sign",
            About::Unrelated { .. } => "unrelated",
            About::Controller { .. } => "controller",
            About::Late { .. } => "late",
            About::Held { .. } => "held",
            About::Stale { .. } => "stale",
            About::Clipped { .. } => "clipped",
            About::Spikes { .. } => "spikes",
            About::Irregular { .. } => "irregular",
            About::Owns { .. } => "owns_the_error",
            About::Excluded { .. } => "excluded",
            About::Zero { .. } => "zero",
            About::Estimated(_) => "estimated",
        }
    }

    /// Whether channels contradict each other, so that nothing can be learnt until the file says which is right.
    pub fn contradicts(&self) -> bool {
        matches!(self, About::Scale { .. } | About::Sign { .. } | About::Unrelated { .. } | About::Controller { .. })
    }
}
