#pragma once
// Pieces of HTML.

#include <string>
#include <string_view>
#include <vector>

namespace drench::html {

/// & < > " ' as entities. Control characters but for line feeds become the replacement character, as bytes that are no
/// UTF-8 do.
std::string escaped(std::string_view text);

/// A table's cell. Numbers stand to the right, in digits of one width.
struct Cell {
  std::string html;
  bool number = false;
};
Cell text(std::string_view plain);          ///< escaped
Cell markup(std::string html);              ///< as it is
Cell number(double value, int digits = 6);  ///< an en dash when it is not finite
Cell whole(double value);

/// The first cell of each row is its heading.
struct Table {
  std::vector<std::string> head;  // plain text
  std::vector<std::vector<Cell>> rows;
  std::string id;  // "" for none
};
/// "" for a table without rows.
std::string table(const Table& table);

/// <section> with a heading.
std::string section(std::string_view id, std::string_view heading, const std::string& content);

std::string paragraph(std::string_view plain);
std::string note(std::string_view plain);  ///< small print

/// A list of plain lines; "" for none.
std::string list(const std::vector<std::string>& lines);

}  // namespace drench::html
