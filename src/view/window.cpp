#include "view/window.hpp"

#include <fmt/format.h>
#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkSliderRepresentation2D.h>
#include <vtkSliderWidget.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>

#include "view/display.hpp"
#include "view/png_files.hpp"
#include "view/show.hpp"

namespace drench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double tick = 0.02;          // s between looks at the clock while it plays
constexpr double look_every = 0.25;    // s between looks for new frames
constexpr double look_at_least = 2;    // the same where none have come for a while
constexpr double follow_share = 0.02;  // of a core's time for the frames of a run that is followed
constexpr const char* help =
    "space  play, pause\n<- ->  previous, next frame\nHome End  first, last\n< >  slower, faster\nc C  colour by next, "
    "previous field\nl  particles or surface\nr  show all\n1 2 3 4  auto, below, front, top\ns  save a picture\n"
    "h  hide this\nq  quit";

/// The mouse turns, shifts and zooms. VTK's own keys do nothing.
class MouseOnly : public vtkInteractorStyleTrackballCamera {
 public:
  static MouseOnly* New();
  vtkTypeMacro(MouseOnly, vtkInteractorStyleTrackballCamera) void OnChar() override {}
};
vtkStandardNewMacro(MouseOnly);

class Window {
 public:
  explicit Window(const ViewOptions& options) : options_(options), show_(options), view_(*parse_view(options.camera)) {
    window_->SetMultiSamples(4);
    const auto [width, height] = picture_size(options.size);
    window_->SetSize(width, height);
    window_->SetWindowName(fmt::format("drench view {}", options.folder).c_str());
    window_->AddRenderer(show_.picture().renderer());
    interactor_->SetRenderWindow(window_);
    interactor_->SetInteractorStyle(style_);
    interactor_->Initialize();
    make_slider();
    make_texts();
    listen(interactor_, vtkCommand::KeyPressEvent, [](Window& w) { w.key(); });
    listen(interactor_, vtkCommand::ConfigureEvent, [](Window& w) { w.fit(); });
    listen(style_, vtkCommand::StartInteractionEvent, [](Window& w) { w.moved_camera_ = true; });
    fit();
    frame(view_);
    refresh();
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// VTK's own loop wakes a thousand times a second while it has a timer. This one sleeps until there is something to
  /// do.
  void run() {
    interactor_->SetDone(false);
    auto* display = static_cast<Display*>(window_->GetGenericDisplayId());
    while (true) {
      interactor_->ProcessEvents();
      if (interactor_->GetDone()) return;
      attempt([](Window& w) { w.on_tick(); });
      wait_for_event(display, next_tick());
    }
  }

 private:
  using Action = void (*)(Window&);

  /// Errors do not go through VTK, which is not made for them: the window says them.
  void listen(vtkObject* object, unsigned long event, Action action) {
    vtkNew<vtkCallbackCommand> command;
    actions_.push_back(std::make_unique<std::pair<Window*, Action>>(this, action));
    command->SetClientData(actions_.back().get());
    command->SetCallback([](vtkObject*, unsigned long, void* data, void*) {
      auto& [self, what] = *static_cast<std::pair<Window*, Action>*>(data);
      self->attempt(what);
    });
    object->AddObserver(event, command);
  }

  void attempt(Action action) {
    try {
      action(*this);
    } catch (const std::exception& e) {
      playing_ = false;
      say(e.what());
    }
  }

  void make_slider() {
    slider_look_->SetMinimumValue(0);
    slider_look_->ShowSliderLabelOff();
    slider_look_->GetPoint1Coordinate()->SetCoordinateSystemToNormalizedDisplay();
    slider_look_->GetPoint2Coordinate()->SetCoordinateSystemToNormalizedDisplay();
    slider_look_->GetPoint1Coordinate()->SetValue(0.22, 0.035);
    slider_look_->GetPoint2Coordinate()->SetValue(0.84, 0.035);
    slider_look_->SetSliderLength(0.012);
    slider_look_->SetSliderWidth(0.02);
    slider_look_->SetTubeWidth(0.004);
    slider_look_->SetEndCapLength(0);
    slider_look_->GetSliderProperty()->SetColor(0.13, 0.45, 0.80);
    slider_look_->GetTubeProperty()->SetColor(0.7, 0.7, 0.73);
    slider_->SetInteractor(interactor_);
    slider_->SetRepresentation(slider_look_);
    slider_->SetAnimationModeToJump();
    slider_->EnabledOn();
    slider_->KeyPressActivationOff();
    listen(slider_, vtkCommand::InteractionEvent, [](Window& w) {
      w.playing_ = false;
      w.go_to(static_cast<std::size_t>(std::lround(w.slider_look_->GetValue())));
    });
  }

  void make_texts() {
    for (vtkTextActor* text : {help_.Get(), line_.Get()}) {
      text->GetTextProperty()->SetColor(0.15, 0.15, 0.18);
      text->GetTextProperty()->SetVerticalJustificationToTop();
      show_.picture().renderer()->AddActor2D(text);
    }
    help_->SetInput(help);
    help_->VisibilityOff();
  }

  /// Texts to the window's size.
  void fit() {
    const int* size = window_->GetSize();
    show_.picture().fit_texts(size[0], size[1]);
    const int font = std::max(12, size[1] / 50);
    for (vtkTextActor* text : {help_.Get(), line_.Get()}) text->GetTextProperty()->SetFontSize(font);
    line_->SetPosition(size[0] / 60.0, size[1] - font);
    help_->SetPosition(size[0] / 60.0, size[1] - 3.5 * font);
  }

  void say(const std::string& text) {
    said_ = text;
    refresh();
  }

  /// Draws what has changed.
  void refresh() {
    slider_look_->SetMaximumValue(std::max<double>(1, static_cast<double>(show_.last())));
    slider_look_->SetValue(static_cast<double>(show_.at()));
    const std::string speed = speed_ == 1 ? "" : fmt::format(", speed {:g}", speed_);
    const std::string color = show_.color() == plain_look ? "" : fmt::format(", {}", show_.color());
    line_->SetInput(fmt::format("frame {} of 0 to {}{}{}{}    {}", show_.at(), show_.last(), color, speed,
                                options_.follow && show_.at() == show_.last() ? ", newest" : "",
                                said_.empty() ? "space plays, arrows step, h shows all keys" : said_)
                        .c_str());
    show_.picture().renderer()->ResetCameraClippingRange();
    window_->Render();
  }

  void frame(const View& view) {
    view_ = view;
    moved_camera_ = false;
    const int* size = window_->GetSize();
    show_.frame(view, size[0], size[1]);
  }

  void go_to(std::size_t i) {
    said_.clear();
    if (i != show_.at()) show_.go_to(i);
    refresh();
  }

  void key() {
    const std::string name = interactor_->GetKeySym() ? interactor_->GetKeySym() : "";
    const std::size_t at = show_.at();
    if (name == "q" || name == "Escape") return interactor_->TerminateApp();
    if (name == "space") return play();
    if (name == "Left" || name == "Right" || name == "Home" || name == "End") {
      playing_ = false;
      return go_to(name == "Home" ? 0 : name == "End" ? show_.last() : name == "Right" ? at + 1 : at - (at > 0));
    }
    said_.clear();
    if (name == "c" || name == "C") show_.next_color(name == "c" ? 1 : -1);
    if (name == "l") show_.switch_liquid();
    if (name == "less" || name == "greater")
      speed_ = std::clamp(name == "less" ? speed_ / 2 : speed_ * 2, 1. / 64, 64.);
    if (name == "h") help_->SetVisibility(!help_->GetVisibility());
    if (name == "r") frame(view_);
    for (const auto& [digit, view] : {std::pair{"1", "auto"}, {"2", "below"}, {"3", "front"}, {"4", "top"}})
      if (name == digit) frame(*parse_view(view));
    if (name == "s") return save();
    refresh();
  }

  /// From the beginning where it has come to the end.
  void play() {
    playing_ = !playing_;
    if (playing_ && show_.at() == show_.last()) show_.go_to(0);
    played_from_ = show_.frames().times()[show_.at()];
    play_began_ = Clock::now();
    go_to(show_.at());
  }

  void save() {
    const fs::path file = fs::path(options_.folder) / "pictures" / fmt::format("view_{:06}.png", show_.at());
    fs::create_directories(file.parent_path());
    for (vtkProp* prop : {static_cast<vtkProp*>(line_.Get()), static_cast<vtkProp*>(slider_look_.Get())})
      prop->VisibilityOff();
    const bool helped = help_->GetVisibility() != 0;
    help_->VisibilityOff();
    save_png(window_, file);
    line_->VisibilityOn();
    slider_look_->VisibilityOn();
    help_->SetVisibility(helped);
    say("saved " + file.string());
  }

  void on_tick() {
    if (playing_) advance();
    const auto now = Clock::now();
    if (!options_.follow || now < next_look_) return;
    const std::clock_t begin = std::clock();
    next_look_ = now + std::chrono::seconds(1);  // where a frame cannot be read
    const bool more = show_.follow();
    if (more) {
      if (!moved_camera_) frame(view_);
      refresh();
    }
    const double cost = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    look_pause_ = more ? look_every : std::min(2 * look_pause_, look_at_least);
    next_look_ = now + std::chrono::duration_cast<Clock::duration>(
                           std::chrono::duration<double>(std::max(look_pause_, cost / follow_share)));
  }

  /// s until there is something to do; negative: until the user does something. Each waking interrupts a thread of the
  /// run.
  double next_tick() const {
    if (playing_) return tick;
    return options_.follow ? std::max(0.0, std::chrono::duration<double>(next_look_ - Clock::now()).count()) : -1;
  }

  /// To the frame that the clock has come to: frames that cannot be drawn in time are left out.
  void advance() {
    const std::vector<double>& times = show_.frames().times();
    const double now = played_from_ + speed_ * std::chrono::duration<double>(Clock::now() - play_began_).count();
    const auto after = std::upper_bound(times.begin(), times.end(), now + 1e-9);
    const auto due = static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, after - times.begin()) - 1);
    if (due != show_.at()) go_to(due);
    if (due == show_.last()) playing_ = false;
  }

  const ViewOptions& options_;
  Show show_;
  View view_;
  vtkNew<vtkRenderWindow> window_;
  vtkNew<vtkRenderWindowInteractor> interactor_;
  vtkNew<MouseOnly> style_;
  vtkNew<vtkSliderRepresentation2D> slider_look_;
  vtkNew<vtkSliderWidget> slider_;
  vtkNew<vtkTextActor> help_, line_;
  std::vector<std::unique_ptr<std::pair<Window*, Action>>> actions_;
  std::string said_;
  bool playing_ = false, moved_camera_ = false;
  double speed_ = 1, played_from_ = 0;  // s of the run
  double look_pause_ = look_every;      // s
  Clock::time_point play_began_, next_look_;
};

}  // namespace

void open_window(const ViewOptions& options) { Window(options).run(); }

}  // namespace drench
