#pragma once
// How many threads a run on the host's cores has, and how they wait for each other.

namespace drench {

/// For a build that computes on the host: unless the environment says so, threads are as many as there are free cores
/// (`asked` > 0: as many as that) and wait by spinning where each has a core, by sleeping otherwise. OpenMP's runtime reads that
/// from the environment when a program starts, so the program is started anew, with the same arguments. Returns where nothing is
/// to be changed, or cannot be.
/// @param quiet without a line on stderr where other programs keep cores busy
void settle_threads(char** argv, int asked, bool quiet);

}  // namespace drench
