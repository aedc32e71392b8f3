// Ordered compaction; twin of src/kernels/gpu/lists.rs.
//
// Which of a workgroup's 64 threads have something to write, and the place of each among them.

// The threads' bits of one turn, of the last and of the next: so that a turn takes one barrier.
var<workgroup> bits: array<atomic<u32>, 6>;

// All of them 0, before the first turn.
fn begin(lane: u32) {
    if lane < 6u {
        atomicStore(&bits[lane], 0u);
    }
    workgroupBarrier();
}

// How many threads before this one have something, and how many have in all. All threads come here together, for the turn-th time.
fn rank(lane: u32, turn: u32, has: bool) -> vec2<u32> {
    let here = 2u * (turn % 3u);
    if has {
        atomicOr(&bits[here + lane / 32u], 1u << (lane % 32u));
    }
    workgroupBarrier();
    // The turn before has been read; that after the next begins with zeros.
    if lane < 2u {
        atomicStore(&bits[2u * ((turn + 2u) % 3u) + lane], 0u);
    }
    let low = atomicLoad(&bits[here]);
    let high = atomicLoad(&bits[here + 1u]);
    let below = (1u << (lane % 32u)) - 1u;
    let before = select(countOneBits(low & below), countOneBits(low) + countOneBits(high & below), lane >= 32u);
    return vec2<u32>(before, countOneBits(low) + countOneBits(high));
}
