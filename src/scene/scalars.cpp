#include "scene/scalars.hpp"

#include <charconv>
#include <limits>
#include <stdexcept>

namespace drench {

using yaml::Value;

namespace {

double bound(std::string_view text) {
  double value = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc{} || end != text.data() + text.size()) throw std::logic_error("a range of the schema is wrong");
  return value;
}

}  // namespace

Range parse_range(std::string_view text) {
  const std::size_t comma = text.find(", ");
  if (text.size() < 6 || comma == text.npos) throw std::logic_error("a range of the schema is wrong");
  return {bound(text.substr(1, comma - 1)), bound(text.substr(comma + 2, text.size() - comma - 3)), text.front() == '(',
          text.back() == ')'};
}

std::string words_or(std::span<const Word<double>> words, const std::string& range) {
  std::string all;
  for (const Word<double>& word : words) all += std::string(word.word) + ", ";
  return all + range;
}

std::optional<double> to_double(const Value& value) {
  if (value.kind != Value::Kind::scalar || value.quoted) return {};
  std::string_view text = value.text;
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  if (text == ".inf" || text == ".Inf" || text == ".INF") return std::numeric_limits<double>::infinity();
  if (text == "-.inf" || text == "-.Inf" || text == "-.INF") return -std::numeric_limits<double>::infinity();
  if (text == ".nan" || text == ".NaN" || text == ".NAN") return std::numeric_limits<double>::quiet_NaN();
  double number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (end != text.data() + text.size() || code == std::errc::invalid_argument) return {};
  // above the largest double, or below the smallest: neither can be kept
  if (code == std::errc::result_out_of_range) return std::numeric_limits<double>::quiet_NaN();
  return number;
}

std::optional<int> to_int(const Value& value, bool& whole) {
  const std::string_view text = value.text;
  int number = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
  whole = value.kind == Value::Kind::scalar && !value.quoted && end == text.data() + text.size() &&
          code != std::errc::invalid_argument;
  if (whole && code == std::errc{}) return number;
  return {};
}

}  // namespace drench
