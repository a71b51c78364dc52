#include "report/report.hpp"

#include <fmt/format.h>

#include <regex>

#include "base/version.hpp"
#include "output/text_file.hpp"
#include "report/html.hpp"
#include "report/page_style.hpp"
#include "report/sections.hpp"
#include "report/thumbnails.hpp"

namespace drench {

namespace fs = std::filesystem;

namespace {

constexpr int frames_of_one = 6, frames_of_two = 4;  // thumbnails of each run: the page stays below 2 MB

std::string figures(const std::vector<Thumbnail>& pictures, bool four = false) {
  if (pictures.empty()) return "";
  std::string out = fmt::format("<div class=\"pictures{}\">\n", four ? " four" : "");
  for (const Thumbnail& p : pictures)
    out += fmt::format("<figure><img src=\"{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n", p.url,
                       html::escaped(p.caption), html::escaped(p.caption));
  return out + "</div>\n";
}

/// Links to the sections that there are.
std::string contents(const std::string& body) {
  static const std::regex heading("<section id=\"([a-z]+)\">\n<h2>([^<]*)</h2>");
  std::string out = "<nav>";
  for (std::sregex_iterator it(body.begin(), body.end(), heading), end; it != end; ++it)
    out += fmt::format("<a href=\"#{}\">{}</a> ", (*it)[1].str(), (*it)[2].str());
  return out + "</nav>\n";
}

std::string title_of(const Runs& runs) {
  return runs.size() < 2 ? runs[0].name : runs[0].name + " and " + runs[1].name;
}

std::string page(const Runs& runs) {
  const std::string body = summary_section(runs) + difference_section(runs) + warning_section(runs) +
                           picture_section(runs) + mass_section(runs) + solve_section(runs) + stage_section(runs) +
                           energy_section(runs) + motion_section(runs) + scene_section(runs) + version_section(runs);
  const std::string title = html::escaped(title_of(runs));
  return fmt::format(
             "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
             "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
             "<meta name=\"generator\" content=\"drench {}\">\n<title>{} · drench</title>\n<style>",
             version_string, title) +
         std::string(style_sheet()) + "</style>\n</head>\n<body>\n" +
         fmt::format("<header>\n<h1>{}</h1>\n{}</header>\n{}<main>\n{}</main>\n", title, failure_section(runs),
                     contents(body), body) +
         fmt::format("<footer>{}</footer>\n",
                     html::note(fmt::format("Written by drench {} ({}).", version_string, git_commit))) +
         "<script>" + std::string(chart_script()) + "</script>\n</body>\n</html>\n";
}

}  // namespace

std::string picture_section(const Runs& runs) {
  std::string out;
  bool cloth = false;
  const bool two = runs.size() > 1;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const Thumbnails pictures = thumbnails(runs[k], two ? frames_of_two : frames_of_one, !two);
    cloth = cloth || pictures.cloth;
    out += run_heading(runs, k) + figures(pictures.rendered.empty() ? pictures.frames : pictures.rendered, two);
    if (!pictures.views.empty()) out += "<h3>The last frame</h3>\n" + figures(pictures.views);
    for (const std::string& line : pictures.notes) out += html::note(line);
  }
  if (cloth) out += "<p class=\"note\">Saturation of the cloth from 0 to 1.2:</p><div class=\"bar\"></div>\n";
  out +=
      html::note("Fluid particles are blue and solids grey. Containers are drawn as outlines, and planes are omitted.");
  return html::section("pictures", "Pictures", out);
}

void write_report(const fs::path& folder, const std::optional<fs::path>& other, const fs::path& file) {
  Runs runs;
  runs.push_back(read_run(folder));
  if (other) runs.push_back(read_run(*other));
  write_atomically(file, page(runs));
}

void write_picture(const fs::path& folder, const fs::path& file, int width, int height) {
  write_png(last_frame(read_run(folder), width, height), file);
}

}  // namespace drench
