#pragma once
// Values of a scene file: how numbers are read, and what is allowed.

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "scene/section.hpp"
#include "scene/yaml_tree.hpp"

namespace drench {

inline constexpr std::size_t text_max_length = 100;
inline constexpr const char* text_allowed = "1 to 100 bytes without control characters";
inline constexpr const char* mesh_name_expected = "the name of an .obj, .ply or .stl file";
inline constexpr const char* mesh_file_allowed = ".obj, .ply, .stl";
inline constexpr const char* key_time_range = "[0, 1e6]";  // s
inline constexpr const char* keys_allowed = "a list of keys [time, value]";
/// How a scene calls what is between two keys.
inline const std::initializer_list<Word<Interpolation>> interpolation_words{
    {"linear", Interpolation::linear}, {"smooth", Interpolation::smooth}, {"step", Interpolation::step}};
inline constexpr const char* mesh_files_allowed = "a list of .obj, .ply, .stl; a name with {} or {:04d}, or with *";
inline constexpr const char* moving_mesh_allowed =
    "a list of .obj, .ply, .stl; a name with {} or {:04d}, or with *; a point cache .pc2, .mdd";
inline constexpr const char* other_files_allowed = "a list of names; a name with {} or {:04d}, or with *";
inline constexpr std::size_t most_files = 100'000;  // of a sequence
inline constexpr const char* switch_allowed = "true, false, on, off";

struct Range {
  double low = 0, high = 0;
  bool low_open = false, high_open = false;
  bool contains(double x) const { return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high); }
};

/// "(0, 1]" as numbers. Throws std::logic_error for any other text.
Range parse_range(std::string_view text);

/// What is allowed where words stand for some numbers: "no, free, [0, 1]".
std::string words_or(std::span<const Word<double>> words, const std::string& range);

/// A plain scalar as a number: NaN if no double can hold it, none if it is no number.
std::optional<double> to_double(const yaml::Value& value);

/// None if it is no whole number, or one that no int can hold; `whole` tells the two apart.
std::optional<int> to_int(const yaml::Value& value, bool& whole);

}  // namespace drench
