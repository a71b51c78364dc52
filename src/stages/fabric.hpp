#pragma once
// Stage fabric (`output: {fabric: true}`): what a textile engineer asks of each porous cloth. It changes nothing but
// the accounts of the faces, which stages absorption and emission keep for it.
//
// Law:    docs/theory/porous.md, section 15.
// Reads:  node_liquid, sample_taken_front, sample_taken_back, sample_given_front, sample_given_back (quanta), rest
//         positions.
// Writes: StepReport::fabrics.
// Exact:  masses are sums of integers.
// Errors: none.
