// Ordered compaction; twin of src/kernels/gpu/tile_binner.rs.
//
// Each thread of a workgroup's WORKERS that has something to write gets its index among those threads.

const WORDS: u32 = WORKERS / 32u;

// A bit for each thread, kept for the last turn, this turn and the next, so that a turn takes one barrier.
var<workgroup> bits: array<atomic<u32>, 3u * WORDS>;

// Clears all bits, before the first turn.
fn begin(lane: u32) {
    if lane < 3u * WORDS {
        atomicStore(&bits[lane], 0u);
    }
    workgroupBarrier();
}

// How many threads before this one have something to write, and how many in all. All threads call this together, for the turn-th time.
fn rank(lane: u32, turn: u32, has: bool) -> vec2<u32> {
    let here = WORDS * (turn % 3u);
    let own = lane / 32u;
    if has {
        atomicOr(&bits[here + own], 1u << (lane % 32u));
    }
    workgroupBarrier();
    // All threads have read the bits of the previous turn, so they are cleared for the turn after the next.
    if lane < WORDS {
        atomicStore(&bits[WORDS * ((turn + 2u) % 3u) + lane], 0u);
    }
    var before = countOneBits(atomicLoad(&bits[here + own]) & ((1u << (lane % 32u)) - 1u));
    var sum = 0u;
    for (var k = 0u; k < WORDS; k++) {
        let count = countOneBits(atomicLoad(&bits[here + k]));
        before += select(0u, count, k < own);
        sum += count;
    }
    return vec2<u32>(before, sum);
}
