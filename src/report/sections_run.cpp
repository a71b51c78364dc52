// What a run was, how it ended, and what it warned of.

#include <fmt/format.h>

#include <cmath>

#include "report/html.hpp"
#include "report/sections.hpp"

namespace drench {
namespace {

using html::escaped;

constexpr std::size_t longest_scene = 200'000;  // bytes that the page has of it

struct EndingWords {
  const char *style, *words;
};

EndingWords words_of(Ending ending) {
  switch (ending) {
    case Ending::done:
      return {"done", "ran to its end"};
    case Ending::interrupted:
      return {"interrupted", "interrupted"};
    case Ending::failed:
      return {"failed", "failed"};
    case Ending::stopped:
      return {"stopped", "stopped by an error"};
    case Ending::unfinished:
      break;
  }
  return {"unfinished", "still running, or killed"};
}

double wall_seconds(const RunRecord& run) { return summary_of(run.stats.column("ms_step")).sum / 1000; }

std::string duration(double seconds) {
  if (seconds < 120) return fmt::format("{:.3g} s", seconds);
  if (seconds < 7200) return fmt::format("{:.0f} min {:02.0f} s", std::floor(seconds / 60), std::fmod(seconds, 60));
  return fmt::format("{:.0f} h {:02.0f} min", std::floor(seconds / 3600), std::floor(std::fmod(seconds, 3600) / 60));
}

class Cards {
 public:
  void add(const char* name, const std::string& value) {
    if (!value.empty()) html_ += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", name, escaped(value));
  }
  std::string take() const { return "<dl class=\"cards\">\n" + html_ + "</dl>\n"; }

 private:
  std::string html_;
};

std::string device_line(const RunRecord& run) {
  const std::string kind = run.device_entry("backend"), device = run.device_entry("device");
  if (kind.empty()) return device.empty() ? run.backend : device;
  return device.empty() ? kind : kind + ", " + device;
}

std::string cards_of(const RunRecord& run) {
  Cards cards;
  const StatsTable& stats = run.stats;
  const Summary time = summary_of(stats.column("time")), step = summary_of(stats.column("step"));
  const double seconds = wall_seconds(run), rows = static_cast<double>(stats.rows());
  cards.add("scene", std::filesystem::path(run.history.scene).stem().string());
  cards.add("simulated time", fmt::format("{:.6g} s of {:.6g} s", time.last, run.number("time.end").value_or(0)));
  cards.add("steps", fmt::format("{:.0f}", step.last));
  cards.add("wall time of the steps", duration(seconds));
  if (rows > 0) cards.add("wall time per step", fmt::format("{:.4g} ms", 1000 * seconds / rows));
  if (stats.has("ms_pressure"))
    cards.add("particles at the end", fmt::format("{:.0f}", summary_of(stats.column("particles")).last));
  cards.add("peak memory of the arrays", run.history.memory.empty() ? "not recorded" : run.history.memory);
  cards.add("device", device_line(run));
  cards.add("threads", run.device_entry("threads"));
  cards.add("precision", run.precision);
  cards.add("program", fmt::format("drench {}", run.version));
  cards.add("begun", run.history.begun);
  return cards.take();
}

std::string badge(const RunRecord& run) {
  const EndingWords words = words_of(run.history.ending);
  std::string line = fmt::format("<p><span class=\"badge {}\">{}</span>", words.style, words.words);
  if (run.stats.rows() > 0)
    line += fmt::format(" after step {:.0f}, t = {:.6g} s", run.stats.column("step").back(),
                        run.stats.column("time").back());
  return line + "</p>\n";
}

std::string failure_box(const Runs& runs, std::size_t k) {
  const RunHistory& history = runs[k].history;
  if (history.ending != Ending::failed && history.ending != Ending::stopped) return "";
  const RunFailureText& f = history.failure;
  const bool in_stage = history.ending == Ending::failed;
  std::string rows;
  const auto row = [&](const char* name, const std::string& value) {
    if (!value.empty()) rows += fmt::format("<dt>{}</dt><dd>{}</dd>\n", name, escaped(value));
  };
  row("cause", f.cause);
  row("stage", f.stage);
  row("step", fmt::format("{}{}", f.step, f.time.empty() ? "" : fmt::format(" (t = {} s)", f.time)));
  row("remedy", f.remedy);
  row("more", f.files);
  return fmt::format(
      "<div class=\"box bad\" id=\"failure{}\">\n<h2>{}{}</h2>\n<dl>\n{}</dl>\n</div>\n", k == 0 ? "" : "-b",
      letter(runs, k),
      in_stage ? fmt::format("The run failed in stage {}", escaped(f.stage)) : "An error stopped the run", rows);
}

}  // namespace

std::string failure_section(const Runs& runs) {
  std::string out;
  for (std::size_t k = 0; k < runs.size(); ++k) out += failure_box(runs, k);
  return out;
}

std::string summary_section(const Runs& runs) {
  std::string out;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    out += run_heading(runs, k) + badge(runs[k]) + cards_of(runs[k]);
    if (runs[k].stats.rows() == 0) out += html::paragraph("No step was completed, so there are no curves.");
    if (runs[k].history.sessions > 1)
      out +=
          html::note(fmt::format("The run was resumed from checkpoints and has {} parts.", runs[k].history.sessions));
  }
  return html::section("summary", "Summary", out);
}

std::string warning_section(const Runs& runs) {
  std::string out;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const RunHistory& h = runs[k].history;
    out += run_heading(runs, k);
    if (h.warnings.empty() && h.totals.empty()) {
      out += html::paragraph("None before or during the run.");
      continue;
    }
    out += "<div class=\"box warn\">\n" + html::list(h.warnings);
    if (!h.totals.empty()) out += html::paragraph("Over the whole run:") + html::list(h.totals);
    out += "</div>\n";
  }
  out += html::note("Warnings before the run are those of drench check. run.log lists all of them with their times.");
  return html::section("warnings", "Warnings", out);
}

std::string scene_section(const Runs& runs) {
  std::string out;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const std::string& text = runs[k].scene_text;
    const std::size_t end = text.size() <= longest_scene ? text.size() : text.rfind('\n', longest_scene) + 1;
    out += run_heading(runs, k) +
           fmt::format("<details><summary>scene.yaml with every default</summary>\n<pre>{}</pre>\n</details>\n",
                       escaped(std::string_view(text).substr(0, end)));
    if (end < text.size())
      out +=
          html::note(fmt::format("The page has the first {} of {} bytes; scene.yaml has the rest.", end, text.size()));
  }
  return html::section("scene", "Resolved scene", out);
}

std::string version_section(const Runs& runs) {
  std::string out;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const RunRecord& r = runs[k];
    html::Table table{{"", ""}, {}, ""};
    const auto row = [&](const std::string& name, const std::string& value) {
      if (!value.empty()) table.rows.push_back({html::text(name), html::text(value)});
    };
    row("drench", r.version);
    row("commit", r.commit);
    row("precision", r.precision);
    row("solver", r.backend);
    for (const auto& [name, value] : r.device) row(name, value);
    row("scene", r.history.scene);
    row("folder", r.folder.string());
    row("log", r.history.begun.empty() ? "" : r.history.begun + " to " + r.history.ended);
    out += run_heading(runs, k) + html::table(table);
  }
  return html::section("versions", "Versions", out);
}

}  // namespace drench
