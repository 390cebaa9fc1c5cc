//! Without MPI there is one process, and nobody to share with.

/// Numbers for, or from, one other process.
pub(crate) type Parcel<T = f64> = (usize, Vec<T>);

/// No processes: the program was built without the feature `mpi`.
#[derive(Clone, Copy, Debug)]
pub enum Processes {}

impl Processes {
    /// The number of this process, from 0.
    pub fn rank(self) -> usize {
        match self {}
    }

    /// How many there are.
    pub fn size(self) -> usize {
        match self {}
    }

    /// What every process has, one after the other.
    pub fn gather(self, _own: &[u64]) -> Vec<u64> {
        match self {}
    }

    /// Waits for what rank 0 says.
    pub fn hear(self) -> Vec<u8> {
        match self {}
    }

    /// Says something to all others.
    pub fn tell(self, _message: &[u8]) {
        match self {}
    }

    /// What every process has, where all have as much.
    pub(crate) fn gather_even<T>(self, _own: &[T], _all: &mut [T]) {
        match self {}
    }

    /// What every process has, to rank 0.
    pub(crate) fn gather_at_first(self, _own: &[u64]) -> Vec<u64> {
        match self {}
    }

    /// Sends each process what there is for it.
    pub(crate) fn deliver(self, _lists: Vec<Vec<u64>>) -> Vec<Vec<u64>> {
        match self {}
    }

    /// Sends parcels, and takes those that come.
    pub(crate) fn swap<T>(self, _out: &[Parcel<T>], _into: &mut [Parcel<T>], _meanwhile: impl FnOnce()) {
        match self {}
    }
}
