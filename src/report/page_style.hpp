#pragma once
// The style sheet and the small script that a report carries with it.

#include <string_view>

namespace drench {

/// Colours of charts are s0 to s7 (lines), f0 to f7 (areas) and t0 to t7 (words): Okabe and Ito's, which the
/// colour-blind tell apart, darker on light ground and lighter on dark ground where their contrast asks for it.
std::string_view style_sheet();

/// Shows the values under the pointer. The page has all that it says without it, too.
std::string_view chart_script();

}  // namespace drench
