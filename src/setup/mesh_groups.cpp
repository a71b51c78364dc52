#include "setup/mesh_groups.hpp"

#include <fstream>
#include <sstream>

namespace drench {
namespace {

/// A line with those that it goes on in; false at the end.
bool whole_line(std::ifstream& file, std::string& line) {
  if (!std::getline(file, line)) return false;
  std::string rest;
  while (line.ends_with('\\') && std::getline(file, rest)) {
    line.back() = ' ';
    line += rest;
  }
  return true;
}

std::vector<std::string> words_of(std::istringstream& line) {
  std::vector<std::string> words;
  std::string word;
  while (line >> word && word[0] != '#') words.push_back(word);
  return words;
}

}  // namespace

std::vector<std::vector<std::string>> face_names(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::vector<std::string>> faces;
  std::vector<std::string> group, object, material;
  std::string line, kind;
  while (whole_line(file, line)) {
    std::istringstream words(line);
    if (!(words >> kind)) continue;
    if (kind == "g") group = words_of(words);
    if (kind == "o") object = words_of(words);
    if (kind == "usemtl") material = words_of(words);
    if (kind != "f") continue;
    faces.push_back(group);
    for (const auto* more : {&object, &material}) faces.back().insert(faces.back().end(), more->begin(), more->end());
  }
  return faces;
}

}  // namespace drench
