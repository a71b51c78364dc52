#include "report/html.hpp"

#include <fmt/format.h>

#include <cmath>

namespace drench::html {
namespace {

constexpr const char* replacement = "\xEF\xBF\xBD";

/// Bytes of the UTF-8 character that begins here; 0 for none that is whole.
std::size_t length_of(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const std::size_t length = byte(0) < 0x80   ? 1
                             : byte(0) < 0xC2 ? 0
                             : byte(0) < 0xE0 ? 2
                             : byte(0) < 0xF0 ? 3
                             : byte(0) < 0xF5 ? 4
                                              : 0;
  if (length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byte(k) & 0xC0) != 0x80) return 0;
  return length;
}

void append_one(std::string& out, char c) {
  switch (c) {
    case '&':
      out += "&amp;";
      break;
    case '<':
      out += "&lt;";
      break;
    case '>':
      out += "&gt;";
      break;
    case '"':
      out += "&quot;";
      break;
    case '\'':
      out += "&#39;";
      break;
    default:
      out += static_cast<unsigned char>(c) < 0x20 && c != '\n' ? std::string(replacement) : std::string(1, c);
  }
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = length_of(text);
    if (length == 1)
      append_one(out, text[0]);
    else
      out += length == 0 ? std::string_view(replacement) : text.substr(0, length);
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return out;
}

Cell text(std::string_view plain) { return {escaped(plain), false}; }
Cell markup(std::string html) { return {std::move(html), false}; }
Cell number(double value, int digits) {
  return {std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "–", true};
}
Cell whole(double value) { return {std::isfinite(value) ? fmt::format("{:.0f}", value) : "–", true}; }

std::string table(const Table& t) {
  if (t.rows.empty()) return "";
  std::string out =
      t.id.empty() ? "<div class=\"scroll\"><table>" : fmt::format("<div class=\"scroll\"><table id=\"{}\">", t.id);
  out += "<thead><tr>";
  for (std::size_t k = 0; k < t.head.size(); ++k)
    out += fmt::format("<th{}>{}</th>", t.rows[0].size() > k && t.rows[0][k].number ? " class=\"n\"" : "",
                       escaped(t.head[k]));
  out += "</tr></thead><tbody>\n";
  for (const auto& row : t.rows) {
    out += "<tr>";
    for (std::size_t k = 0; k < row.size(); ++k) {
      const char* tag = k == 0 ? "th" : "td";
      out += fmt::format("<{}{}>{}</{}>", tag, row[k].number ? " class=\"n\"" : "", row[k].html, tag);
    }
    out += "</tr>\n";
  }
  return out + "</tbody></table></div>\n";
}

std::string section(std::string_view id, std::string_view heading, const std::string& content) {
  return fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", id, escaped(heading), content);
}

std::string paragraph(std::string_view plain) { return fmt::format("<p>{}</p>\n", escaped(plain)); }
std::string note(std::string_view plain) { return fmt::format("<p class=\"note\">{}</p>\n", escaped(plain)); }

std::string list(const std::vector<std::string>& lines) {
  if (lines.empty()) return "";
  std::string out = "<ul>\n";
  for (const std::string& line : lines) out += fmt::format("<li>{}</li>\n", escaped(line));
  return out + "</ul>\n";
}

}  // namespace drench::html
