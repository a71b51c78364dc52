#pragma once
// Which known word a misspelt one was probably meant to be.

#include <string>
#include <vector>

namespace drench {

/// The word of `known` with the fewest edits to `word`, at most a third of its letters, or else the only one that
/// begins with it; "" if there is none.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

}  // namespace drench
