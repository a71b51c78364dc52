#pragma once
// The rest length of a stitch (docs/theory/cloth.md, Eq. 4s).

namespace drench {

/// m, at a time (s): `length` at 0 s, 0 from `end` on, with no speed at either.
inline double stitch_rest_length(double length, double end, double time) {
  if (!(time < end)) return 0;
  const double part = time / end;
  return length * (1 - part * part * (3 - 2 * part));
}

}  // namespace drench
