#pragma once
// How many of the machine's cores a run can have.

namespace drench {

/// Cores that this process is allowed to use.
int allowed_cores();

/// What a thread gets of a core now, 1 at most: it spins for 30 ms and tells how long it ran.
double share_of_core();

/// What it gets of them now, in cores: a thread on each spins for 30 ms and tells how long it ran.
double free_cores();

/// Threads for so many free cores, of `cores`; at least 1. Three quarters of a core count as one.
int threads_for(double free, int cores);

}  // namespace drench
