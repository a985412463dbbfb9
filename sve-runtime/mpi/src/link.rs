//! Values as messages of MPI.
//!
//! Input: a value and a rank. Output: the value on this rank. A message consists of the length of
//! the value's bytes, in 8 bytes, and the bytes. Counts of MPI are 32-bit numbers with a sign, so
//! longer messages are sent in pieces.
//!
//! Open MPI waits by polling without a pause. A rank that waits while its threads compute, or while
//! other ranks compute on the same cores, therefore sleeps between two polls.

use std::thread;
use std::time::Duration;

use mpi::Tag;
use mpi::collective::SystemOperation;
use mpi::point_to_point::MatchedReceiveVec as _;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{
    Communicator, CommunicatorCollectives as _, Destination as _, Root as _, Source as _,
};
use serde::{Serialize, de::DeserializeOwned};

/// Largest number of bytes of a piece.
pub(crate) const PIECE: usize = 1 << 30;

/// Number of bytes of a length.
const LENGTH: usize = 8;

/// Tag of the first piece of a message.
const FIRST: Tag = 0;
/// Tag of later pieces of a message.
const LATER: Tag = 1;

/// Shortest and longest pause between two polls for a message.
const PAUSE: [Duration; 2] = [Duration::from_micros(50), Duration::from_millis(1)];

/// A separate communicator, so that no message of the program is mistaken for a message of a run.
pub(crate) struct Link {
    world: SimpleCommunicator,
    piece: usize,
}

impl Link {
    /// Returns a link with pieces of so many bytes, at least 8.
    pub(crate) fn new(world: &impl Communicator, piece: usize) -> Self {
        let world = world.duplicate();
        Self { world, piece }
    }

    pub(crate) fn rank(&self) -> i32 {
        self.world.rank()
    }

    pub(crate) fn size(&self) -> i32 {
        self.world.size()
    }

    /// Sends a value to a rank.
    pub(crate) fn send(&self, rank: i32, value: &impl Serialize) {
        let content = bytes(value);
        let message = [&(content.len() as u64).to_le_bytes()[..], &content].concat();
        let to = self.world.process_at_rank(rank);
        for (k, piece) in message.chunks(self.piece).enumerate() {
            to.send_with_tag(piece, if k == 0 { FIRST } else { LATER });
        }
    }

    /// Receives a value from any rank, if one has arrived.
    pub(crate) fn try_receive<T: DeserializeOwned>(&self) -> Option<(i32, T)> {
        let any = self.world.any_process();
        let arrived = any.immediate_matched_probe_with_tag(FIRST)?;
        let (first, status) = arrived.matched_receive_vec();
        let rank = status.source_rank();
        Some((rank, self.rest(rank, first)))
    }

    /// Waits for a value from a rank, with pauses.
    pub(crate) fn receive<T: DeserializeOwned>(&self, rank: i32) -> T {
        let from = self.world.process_at_rank(rank);
        let mut pause = PAUSE[0];
        loop {
            if let Some(arrived) = from.immediate_matched_probe_with_tag(FIRST) {
                let (first, _) = arrived.matched_receive_vec();
                return self.rest(rank, first);
            }
            thread::sleep(pause);
            pause = (pause * 3 / 2).min(PAUSE[1]);
        }
    }

    /// Receives the other pieces of a message.
    fn rest<T: DeserializeOwned>(&self, rank: i32, mut message: Vec<u8>) -> T {
        let from = self.world.process_at_rank(rank);
        let length = message.first_chunk::<LENGTH>().copied();
        let length = length.map_or(0, u64::from_le_bytes);
        while ((message.len() - LENGTH) as u64) < length {
            let (piece, _) = from.receive_vec_with_tag::<u8>(LATER);
            message.extend(piece);
        }
        value(&message[LENGTH..])
    }

    /// Sends a value from a rank to all ranks. The other ranks give `None`.
    pub(crate) fn broadcast<T: Serialize + DeserializeOwned>(
        &self,
        rank: i32,
        sent: Option<T>,
    ) -> T {
        let root = self.world.process_at_rank(rank);
        let mut message = sent.as_ref().map(bytes).unwrap_or_default();
        let mut length = message.len() as u64;
        root.broadcast_into(&mut length);
        message.resize(length as usize, 0);
        for piece in message.chunks_mut(self.piece) {
            root.broadcast_into(piece);
        }
        sent.unwrap_or_else(|| value(&message))
    }

    /// Returns the smallest of the numbers of all ranks.
    pub(crate) fn least(&self, number: i32) -> i32 {
        let mut least = number;
        (self.world).all_reduce_into(&number, &mut least, SystemOperation::min());
        least
    }

    /// Ends the program on all ranks.
    pub(crate) fn abort(&self) -> ! {
        self.world.abort(1)
    }
}

fn bytes(value: &impl Serialize) -> Vec<u8> {
    match postcard::to_stdvec(value) {
        Ok(bytes) => bytes,
        Err(error) => panic!("a message of sve-mpi has no stored form: {error}"),
    }
}

fn value<T: DeserializeOwned>(bytes: &[u8]) -> T {
    match postcard::from_bytes(bytes) {
        Ok(value) => value,
        Err(error) => panic!(
            "a message of sve-mpi cannot be read ({error}): do all ranks run the same program?"
        ),
    }
}
