#pragma once
// Where two parts of a closed mesh's surface face each other closely (thighs, armpits, fingers), cloth between them
// needs the distance to each: the distance to the whole surface has a ridge there.

#include "state/model.hpp"

namespace drench {

/// Sets body.parts for cloth of a thickness (m), from body.field, which is filled; leaves them empty for a mesh without
/// such parts. Law: docs/theory/cloth.md, section 11, with the details in docs/dev/contacts.md. The same bits with any
/// number of threads.
void find_facing_parts(Body& body, double thickness, int threads = 1);

}  // namespace drench
