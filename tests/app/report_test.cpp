// drench report: the page says what the run's files say, of good runs, of failed and of damaged ones, and stays small.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <regex>

#include "commands_fixture.hpp"
#include "report/axis.hpp"
#include "report/html.hpp"
#include "report/run_history.hpp"

namespace drench::test {
namespace {

constexpr std::uintmax_t largest_page = 2'000'000;  // bytes

/// The cells of a table of the page, a row each, without their markup.
std::vector<std::vector<std::string>> table_of(const std::string& page, const std::string& id) {
  const std::size_t begin = page.find("<table id=\"" + id + "\">");
  if (begin == std::string::npos) return {};
  const std::string body = page.substr(begin, page.find("</table>", begin) - begin);
  static const std::regex row("<tr>(.*)</tr>"), cell("<t[hd][^>]*>(.*?)</t[hd]>"), tag("<[^>]*>");
  std::vector<std::vector<std::string>> rows;
  for (std::sregex_iterator r(body.begin(), body.end(), row), end; r != end; ++r) {
    const std::string text = (*r)[1];
    rows.emplace_back();
    for (std::sregex_iterator c(text.begin(), text.end(), cell); c != end; ++c)
      rows.back().push_back(std::regex_replace((*c)[1].str(), tag, ""));
  }
  return rows;
}

/// The row that begins so.
std::vector<std::string> row_of(const std::string& page, const std::string& id, const std::string& heading) {
  for (const auto& row : table_of(page, id))
    if (!row.empty() && row[0].starts_with(heading)) return row;
  ADD_FAILURE() << "no row " << heading << " in " << id;
  return std::vector<std::string>(10, "0");
}

class Report : public Commands {
 protected:
  void run(const std::string& folder, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"run", "tiny.yaml", "--quiet", "-o", folder};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome o = drench(words);
    ASSERT_EQ(o.code, 0) << o.err;
  }
  std::string report(const std::vector<std::string>& folders, const std::string& file = "page.html") {
    std::vector<std::string> words{"report"};
    words.insert(words.end(), folders.begin(), folders.end());
    words.insert(words.end(), {"-o", file});
    const Outcome o = drench(words);
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_EQ(o.err, "");
    EXPECT_LT(fs::file_size(here() / file), largest_page);
    return read_text(here() / file);
  }
};

void expect_near(const std::string& shown, double value) {
  EXPECT_NEAR(std::stod(shown), value, 1e-3 * std::abs(value));
}

TEST_F(Report, SaysWhatStatsCsvSays) {
  run("o");
  const Outcome o = drench({"report", "o"});
  ASSERT_EQ(o.code, 0) << o.err;
  const std::string page = read_text(here() / "o/report.html");
  const Table stats = read_table(here() / "o/stats.csv");
  const std::size_t last = stats.rows.size() - 1;
  for (const auto& [heading, column] :
       {std::pair{"in the liquid", "mass_fluid"}, {"in cloth", "mass_cloth"}, {"drained", "mass_drained"}}) {
    const auto row = row_of(page, "mass-table", heading);
    EXPECT_NEAR(std::stod(row[1]), stats.number(0, column), 1e-8 * stats.number(0, column)) << heading;
    EXPECT_NEAR(std::stod(row[2]), stats.number(last, column), 1e-8 * stats.number(last, column)) << heading;
  }
  EXPECT_EQ(row_of(page, "mass-table", "error")[3], "0");
  const auto of_column = [&](const std::string& column) {
    std::vector<double> values;
    for (std::size_t k = 0; k <= last; ++k) values.push_back(stats.number(k, column));
    return values;
  };
  const auto sum = [](const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); };
  for (const auto& [name, iterations, error] : {std::array{"density", "density_iterations", "density_error"},
                                                {"divergence", "divergence_iterations", "divergence_error"},
                                                {"cloth", "cloth_iterations", "cloth_residual"}}) {
    const auto solve = row_of(page, "solve-table", name);
    const auto counts = of_column(iterations), errors = of_column(error);
    expect_near(solve[1], sum(counts) / static_cast<double>(last + 1));
    EXPECT_EQ(std::stod(solve[3]), *std::max_element(counts.begin(), counts.end())) << name;
    const double worst = *std::max_element(errors.begin(), errors.end());
    EXPECT_NEAR(std::stod(solve[6]), worst, 1e-2 * worst) << name;
    EXPECT_EQ(solve[8], "0") << "all solves of this scene converge";
  }
  double all_stages = 0;
  for (const std::string& column : stats.header)
    if (column.starts_with("ms_") && column != "ms_step") all_stages += sum(of_column(column));
  for (const std::string& column : stats.header) {
    if (!column.starts_with("ms_") || column == "ms_step") continue;
    const double share = 100 * sum(of_column(column)) / all_stages;
    EXPECT_NEAR(std::stod(row_of(page, "stage-table", column.substr(3))[4]), share, 1e-2 * share + 1e-9) << column;
  }
  expect_near(row_of(page, "stage-table", "whole step")[1], sum(of_column("ms_step")) / 1000);
  expect_near(row_of(page, "motion-table", "fastest particle")[3], stats.number(last, "fluid_speed"));
  const Table energy = read_table(here() / "o/energy.csv");
  const auto total = row_of(page, "energy-table", "total");
  expect_near(total[1], energy.number(0, "total"));
  expect_near(total[2], energy.number(energy.rows.size() - 1, "total"));
  EXPECT_NE(page.find("ran to its end"), std::string::npos);
}

TEST_F(Report, NeedsNothingButItself) {
  run("o");
  const std::string page = report({"o"});
  for (const char* outside : {"<link", "@import", "src=\"http", "href=\"http", "url(", "<iframe", "fetch("})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  int pictures = 0;
  for (std::size_t at = 0; (at = page.find("<img src=\"data:image/jpeg;base64,", at)) != std::string::npos; ++at)
    ++pictures;
  EXPECT_EQ(pictures, 8) << "five frames, and three views of the last";
}

/// A PNG of one red pixel.
const std::string red_png(
    "\211\120\116\107\015\012\032\012\000\000\000\015\111\110\104\122\000\000\000\001\000\000\000\001\010"
    "\002\000\000\000\220\167\123\336\000\000\000\014\111\104\101\124\170\234\143\370\317\300\000\000\003"
    "\001\001\000\311\376\222\357\000\000\000\000\111\105\116\104\256\102\140\202",
    69);

TEST_F(Report, TakesRenderedPicturesOfThisRun) {
  run("o");
  fs::create_directory(here() / "o/pictures");
  write_text(here() / "o/pictures/frame_0000.png", red_png);
  EXPECT_NE(report({"o"}).find("<figcaption>frame_0000.png</figcaption>"), std::string::npos);
  fs::last_write_time(here() / "o/pictures/frame_0000.png",
                      fs::last_write_time(here() / "o/scene.yaml") - std::chrono::seconds(5));
  EXPECT_EQ(report({"o"}).find("frame_0000.png"), std::string::npos) << "of an earlier run";
  write_text(here() / "o/pictures/frame_0000.png", "no picture");
  EXPECT_NE(report({"o"}).find("Rendered pictures are missing: o/pictures/frame_0000.png"), std::string::npos);
}

TEST_F(Report, SetsTwoRunsSideBySide) {
  run("a");
  run("b", {"--set", "fluid.viscosity=0.01", "--until", "0.03"});
  const std::string page = report({"a", "b"});
  const auto viscosity = row_of(page, "scene-differences", "fluid.viscosity");
  EXPECT_EQ(viscosity[2], "0.01");
  EXPECT_NE(viscosity[1], viscosity[2]);
  EXPECT_EQ(row_of(page, "scene-differences", "time.end")[2], "0.03");
  EXPECT_EQ(table_of(page, "scene-differences").size(), 3U) << "a head and two keys";
  const Table a = read_table(here() / "a/stats.csv"), b = read_table(here() / "b/stats.csv");
  std::size_t same_time = 0;
  while (a.number(same_time, "time") < 0.03 - 1e-9) ++same_time;
  const auto energy = row_of(page, "state-differences", "kinetic energy");
  expect_near(energy[1], a.number(same_time, "kinetic_energy"));
  expect_near(energy[2], b.number(b.rows.size() - 1, "kinetic_energy"));
  EXPECT_NE(page.find("class=\"l s0 dashed\""), std::string::npos) << "the second run's curves";
  EXPECT_NE(page.find("<table id=\"mass-table-b\">"), std::string::npos);
  EXPECT_NE(report({"a", "a"}).find("The resolved scenes are equal."), std::string::npos);
}

TEST_F(Report, OfAFailedRunSaysFirstWhy) {
  write_text(here() / "piston.yaml", piston_scene);
  const Outcome o = drench({"run", "piston.yaml", "-o", "o", "--quiet", "--set", "output.report=true"});
  ASSERT_EQ(o.code, 1) << o.err;
  const std::string page = read_text(here() / "o/report.html");
  const std::size_t why = page.find("The run failed in stage pressure"),
                    summary = page.find("<section id=\"summary\">");
  ASSERT_NE(why, std::string::npos);
  EXPECT_LT(why, summary);
  const std::string box = page.substr(why, summary - why);
  const Table stats = read_table(here() / "o/stats.csv");
  for (const std::string& part :
       {std::string("<dt>cause</dt><dd>the liquid collapses"),
        std::string("<dt>remedy</dt><dd>the density solve reached"),
        fmt::format("<dt>step</dt><dd>{:.0f} (t = ", stats.number(stats.rows.size() - 1, "step")),
        std::string("o/failure.vtu")})
    EXPECT_NE(box.find(part), std::string::npos) << part << "\n" << box;
  EXPECT_NE(page.find("the density solve did not converge in "), std::string::npos);
  EXPECT_GE(std::stod(row_of(page, "solve-table", "density")[8]), 10) << "steps of a collapse";
  EXPECT_EQ(page.find("not recorded</dd>"), std::string::npos) << "the peak memory of a failed run is known, too";
}

TEST_F(Report, IsWrittenByARunThatIsAskedTo) {
  run("o", {"--set", "output.report=true"});
  EXPECT_NE(read_text(here() / "o/report.html").find("ran to its end"), std::string::npos);
  run("without");
  EXPECT_FALSE(fs::exists(here() / "without/report.html"));
  run("o", {"--overwrite"});
  EXPECT_FALSE(fs::exists(here() / "o/report.html")) << "it was of the earlier run";
}

TEST_F(Report, OfARunThatWasKilledHasItsWholeRows) {
  run("o");
  std::string stats = read_text(here() / "o/stats.csv");
  const std::size_t rows = read_table(here() / "o/stats.csv").rows.size();
  write_text(here() / "o/stats.csv", stats.substr(0, stats.size() - 20));
  const std::string log = read_text(here() / "o/run.log");
  write_text(here() / "o/run.log", log.substr(0, log.find(" steps to t = ")));
  const std::string page = report({"o"});
  EXPECT_NE(page.find("still running, or killed"), std::string::npos);
  EXPECT_NE(page.find(fmt::format("after step {},", rows - 1)), std::string::npos);
  EXPECT_EQ(row_of(page, "solve-table", "density")[8], "–") << "nobody has counted them";
}

TEST_F(Report, WithoutStepsAndFramesStillSaysWhatItKnows) {
  run("o", {"--steps", "0", "--set", "output.every=0"});
  const std::string page = report({"o"});
  EXPECT_NE(page.find("No step was completed"), std::string::npos);
  EXPECT_NE(page.find("has written no frames"), std::string::npos);
  EXPECT_NE(page.find("spacing: 0.02  # m"), std::string::npos);
}

TEST_F(Report, NamesAreNoMarkup) {
  write_text(here() / "tiny.yaml",
             std::regex_replace(std::string(tiny_scene), std::regex("name: sheet"), "name: '<b>&\"sheet'"));
  run("a<i>&b");
  const std::string page = report({"a<i>&b"});
  EXPECT_EQ(page.find("<b>"), std::string::npos);
  EXPECT_EQ(page.find("<i>"), std::string::npos);
  EXPECT_NE(page.find("<h1>a&lt;i&gt;&amp;b</h1>"), std::string::npos);
}

TEST_F(Report, OfALongRunStaysSmall) {
  run("o");
  const std::string stats = read_text(here() / "o/stats.csv");
  const auto lines = split(stats, '\n');
  std::string longer = lines[0] + "\n";
  for (int step = 1; step <= 100'000; ++step) {
    const std::string& row = lines[1 + static_cast<std::size_t>(step * 7 % 20)];
    longer += fmt::format("{},{}{}\n", step, 1e-3 * step, row.substr(row.find(',', row.find(',') + 1)));
  }
  write_text(here() / "o/stats.csv", longer);
  const std::string page = report({"o", "o"});
  EXPECT_NE(page.find("after step 100000, t = 100 s"), std::string::npos);
}

TEST_F(Report, Refuses) {
  fs::create_directory(here() / "empty");
  run("o");
  expect_refusal({"report", "nowhere"}, "drench: nowhere: no such folder");
  expect_refusal({"report", "empty"}, "drench: empty: holds no output of a run; allowed: ");
  expect_refusal({"report", "o", "empty"}, "drench: empty: holds no output of a run");
  expect_refusal({"report", "o", "-o", "nowhere/page.html"}, "drench: nowhere: there is no such folder");
  expect_refusal({"report", "o", "-o", "empty"}, "drench: empty: is a folder; name a file with -o");
  expect_refusal({"report"}, "OUT is required");
  write_text(here() / "o/stats.csv", "step,time,dt\n1,0.1,0.1\n2,zero,0.1\n");
  expect_refusal({"report", "o"}, "o/stats.csv:3: is not a row of 3 numbers");
}

TEST(ReportCurves, KeepTheirPeaksAndEndsWhenTheyAreThinned) {
  std::vector<double> x, y;
  for (int i = 0; i < 100'000; ++i) {
    x.push_back(i);
    y.push_back(std::sin(1e-3 * i));
  }
  y[54'321] = 9;
  y[12'345] = -7;
  const auto points = thinned(x, y, 0, 99'999, 300);
  EXPECT_LE(points.size(), 4U * 301U);
  const auto has = [&](double at, double value) {
    return std::any_of(points.begin(), points.end(), [&](const Point& p) { return p.x == at && p.y == value; });
  };
  EXPECT_TRUE(has(54'321, 9));
  EXPECT_TRUE(has(12'345, -7));
  EXPECT_EQ(points.front().x, 0);
  EXPECT_EQ(points.back().x, 99'999);
  EXPECT_TRUE(std::is_sorted(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.x < b.x; }));
}

TEST(ReportCurves, AxesHaveRoundTicksAroundAllValues) {
  const Axis plain = Axis::linear(3, 97);
  EXPECT_EQ(plain.least(), 0);
  EXPECT_EQ(plain.most(), 100);
  EXPECT_EQ(plain.ticks().size(), 6U);
  const Axis tight = Axis::linear(1.0001, 1.0493);
  EXPECT_EQ(tight.ticks().front().text, "1");
  EXPECT_GT(tight.place(1.0493), 0.9);
  EXPECT_NEAR(Axis::linear(4, 4).place(4), 0.5, 1e-12) << "a level line stands in the middle";
  const Axis decades = Axis::decades(3e-5, 2e-3);
  EXPECT_EQ(decades.ticks().front().text, "10⁻²");
  EXPECT_EQ(decades.ticks().back().text, "10⁻⁵");
  EXPECT_EQ(decades.place(0), 0) << "on the axis";
  EXPECT_NEAR(decades.place(1e-3), 2.0 / 3, 1e-12);
}

TEST(ReportHtml, EscapesMarkupAndBrokenCharacters) {
  EXPECT_EQ(html::escaped("<a href='x'>\"&\"</a>"), "&lt;a href=&#39;x&#39;&gt;&quot;&amp;&quot;&lt;/a&gt;");
  EXPECT_EQ(html::escaped("m², Δt\n"), "m², Δt\n");
  EXPECT_EQ(html::escaped("a\xFF\x01"), "a\xEF\xBF\xBD\xEF\xBF\xBD");
}

TEST(ReportHistory, ARunThatWasGoneOnWithEndsAsItsLastPart) {
  const TempFolder folder;
  write_text(folder.path() / "run.log",
             "2026-01-02 03:04:05  drench 0.9.0 (abc, float precision), backend kokkos: backend: OpenMP\n"
             "2026-01-02 03:04:05  scene a.yaml\n"
             "2026-01-02 03:04:06  warning: one\n"
             "2026-01-02 03:04:07  interrupted at step 5\n"
             "2026-01-02 03:04:07  5 steps to t = 0.1 s in 1.0 s, mass error 0 kg\n"
             "2026-01-02 03:05:05  drench 0.9.0 (abc, float precision), backend kokkos: backend: OpenMP\n"
             "2026-01-02 03:05:06  warning: one\n"
             "2026-01-02 03:05:07  stopped at step 9: disk full\n");
  const RunHistory h = read_history(folder.path() / "run.log");
  EXPECT_EQ(h.sessions, 2);
  EXPECT_EQ(h.ending, Ending::stopped);
  EXPECT_EQ(h.failure.step, 9);
  EXPECT_EQ(h.failure.cause, "disk full");
  EXPECT_EQ(h.warnings, std::vector<std::string>{"one"});
  EXPECT_EQ(h.begun, "2026-01-02 03:04:05");
  EXPECT_EQ(h.ended, "2026-01-02 03:05:07");
}

}  // namespace
}  // namespace drench::test
