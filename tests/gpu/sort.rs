//! Prefix sums and the sort on the device against the standard library's.

use crate::device::device;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use relcp::gpu::Gpu;
use relcp::internals::gpu::{Buffer, Scan, Sort, WORKGROUP};

const SCAN_BLOCK: u64 = 8 * WORKGROUP as u64;
const SORT_BLOCK: u64 = 16 * WORKGROUP as u64;

/// More than one dimension of a dispatch takes.
const FOLDED: u64 = 65_535 * WORKGROUP as u64 + 12_345;

fn words(bytes: &[u8]) -> Vec<u32> {
    bytemuck::pod_collect_to_vec(bytes)
}

fn random(seed: u64, n: u64, below: u32) -> Vec<u32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    (0..n).map(|_| rng.random_range(0..below)).collect()
}

fn sums(gpu: &Gpu, scan: &mut Scan, counts: &[u32]) -> Vec<u32> {
    let n = counts.len() as u64;
    let buffer = Buffer::with(gpu, "counts", 4, bytemuck::cast_slice(counts)).unwrap();
    let out = Buffer::new(gpu, "sums", 4, n + 2).unwrap();
    out.write(gpu, 0, bytemuck::cast_slice(&vec![77u32; n as usize + 2]));
    let mut record = gpu.record();
    scan.exclusive(&mut record, &buffer, &out, n).unwrap();
    let sums = words(&record.read(&[(&out, 0..4 * (n + 2))]).unwrap()[0]);
    assert_eq!(sums[n as usize + 1], 77, "written past the end");
    sums[..=n as usize].to_vec()
}

fn expected(counts: &[u32]) -> Vec<u32> {
    let mut sum = 0u32;
    let mut sums = vec![0];
    sums.extend(counts.iter().map(|count| {
        sum = sum.wrapping_add(*count);
        sum
    }));
    sums
}

#[test]
fn sums_of_every_length() {
    let Some(gpu) = device() else { return };
    let mut scan = Scan::new(gpu).unwrap();
    let block = SCAN_BLOCK;
    let lengths = [0, 1, 2, 7, 8, 9, 127, 128, 129, block - 2, block - 1, block, block + 1, 3 * block - 1, 50_000];
    // Longest first, too: memory of a longer scan must not show in a shorter one.
    for n in lengths.into_iter().chain(lengths.into_iter().rev()) {
        let counts = random(n, n, 9);
        assert!(sums(gpu, &mut scan, &counts) == expected(&counts), "{n} entries");
    }
}

#[test]
fn sums_over_three_levels_and_past_the_groups_of_one_dimension() {
    let Some(gpu) = device() else { return };
    let mut scan = Scan::new(gpu).unwrap();
    for n in [SCAN_BLOCK * SCAN_BLOCK - 1, SCAN_BLOCK * SCAN_BLOCK, FOLDED] {
        let counts = random(n, n, u32::MAX);
        assert!(sums(gpu, &mut scan, &counts) == expected(&counts), "{n} entries");
    }
}

/// Sorts, and returns how long the device took.
fn check(gpu: &Gpu, sort: &mut Sort, keys: &[u32], bits: u32) -> f64 {
    let n = keys.len() as u64;
    let values: Vec<u32> = (0..keys.len() as u32).map(|k| k ^ 0x5000_0000).collect();
    let mut key_buffer = Buffer::with(gpu, "keys", 4, bytemuck::cast_slice(keys)).unwrap();
    let mut value_buffer = Buffer::with(gpu, "values", 4, bytemuck::cast_slice(&values)).unwrap();
    gpu.wait().unwrap();
    let begun = std::time::Instant::now();
    let mut record = gpu.record();
    sort.by_key(&mut record, &mut key_buffer, &mut value_buffer, n, bits).unwrap();
    record.submit().unwrap();
    gpu.wait().unwrap();
    let seconds = begun.elapsed().as_secs_f64();
    assert!(key_buffer.capacity() >= n && value_buffer.capacity() >= n);
    let read = record.read(&[(&key_buffer, 0..4 * n), (&value_buffer, 0..4 * n)]).unwrap();
    let mask = ((1u64 << bits) - 1) as u32;
    let mut sorted: Vec<(u32, u32)> = keys.iter().copied().zip(values).collect();
    sorted.sort_by_key(|(key, _)| key & mask);
    let found: Vec<(u32, u32)> = words(&read[0]).into_iter().zip(words(&read[1])).collect();
    assert!(found == sorted, "{n} keys, {bits} bits");
    seconds
}

#[test]
fn sorts_keys_of_every_kind() {
    let Some(gpu) = device() else { return };
    let mut sort = Sort::new(gpu).unwrap();
    let block = SORT_BLOCK;
    for n in [0, 1, 2, 15, 16, 17, 128, block - 1, block, block + 1, 3 * block + 5, 100_000] {
        check(gpu, &mut sort, &random(n, n, u32::MAX), 32);
        check(gpu, &mut sort, &random(n, n, 5), 3);
        check(gpu, &mut sort, &vec![u32::MAX; n as usize], 32);
        check(gpu, &mut sort, &(0..n as u32).collect::<Vec<_>>(), 17);
        check(gpu, &mut sort, &(0..n as u32).rev().collect::<Vec<_>>(), 17);
    }
}

#[test]
fn sorts_by_the_lowest_bits_only() {
    let Some(gpu) = device() else { return };
    let mut sort = Sort::new(gpu).unwrap();
    let keys = random(5, 5000, u32::MAX);
    for bits in [0, 1, 4, 5, 10, 31] {
        check(gpu, &mut sort, &keys, bits);
    }
}

#[test]
fn sorts_past_the_groups_of_one_dimension() {
    let Some(gpu) = device() else { return };
    let mut sort = Sort::new(gpu).unwrap();
    for n in [1 << 17, FOLDED] {
        let seconds = check(gpu, &mut sort, &random(1, n, 1 << 20), 20);
        println!("{n} keys of 20 bits: {:.1} ms", 1e3 * seconds);
    }
}

/// The sort's own buffers were made larger than the caller's, which are exchanged for them, and so on for ever.
#[test]
fn sorting_again_and_again_takes_no_more_memory() {
    let Some(gpu) = device() else { return };
    let mut sort = Sort::new(gpu).unwrap();
    let n = 5_000u64;
    let [mut keys, mut values] = [(); 2].map(|()| Buffer::new(gpu, "sorted", 4, n).unwrap());
    let mut largest = 0;
    for round in 0..20 {
        let mut record = gpu.record();
        // One digit: an odd number of exchanges.
        sort.by_key(&mut record, &mut keys, &mut values, n, 4).unwrap();
        record.submit().unwrap();
        if round == 1 {
            largest = keys.capacity().max(values.capacity());
        }
    }
    assert!(keys.capacity().max(values.capacity()) <= largest);
}
