#pragma once
// Scenes drawn at random that are valid and small: at most some hundred particles and three cloths of 12 × 12 nodes,
// with any bodies, processes and keys that the loader allows but files. Most values are ordinary; some are anywhere in
// the loader's ranges.

#include <cstdint>
#include <random>
#include <string>

namespace drench::test {

struct RandomScene {
  std::string yaml;
  bool closed = false;    ///< nothing moves by prescription and no reservoir supplies: the energy is known from outside
  bool ordinary = false;  ///< no value is at the far end of its range
  bool bounded = false;   ///< saturation control is on
  bool folds = false;     ///< cloth collides with itself
  bool crowded = false;   ///< one of several cloths begins with more than it holds, which may find no room to leave
};

class SceneDraw {
 public:
  /// `narrow`: without wind, spins, slip, adhesion of bodies, keyed values, sample_spacing, regions, time.mode error,
  /// mirrored walls, named fabrics, films, compressible fabric, soft pins, drains, rain, sprays, hinges,
  /// hysteresis and pores of two sizes.
  explicit SceneDraw(std::uint64_t seed, bool narrow = false)
      : random_(seed),
        more_(seed + 0x9e3779b97f4a7c15),
        dyes_(seed + 0x3c6ef372fe94f82a),
        patches_(seed + 0xdaa66d2c7ddf743f),
        others_(seed + 0x78dde6e5fd29f054),
        newest_(seed + 0x1715609d9f3bcd89),
        latest_(seed + 0xb54cda58fbee4a26),
        porous_(seed + 0x9e6c63d0876a9a47),
        sprays_(seed + 0x52dce729da3ed6c3),
        narrow_(narrow) {}
  RandomScene scene();

 private:
  double uniform(double low, double high);
  double logarithmic(double low, double high);
  /// Usually within [low, high], sometimes within [least, most], both by their logarithms.
  double usually(double low, double high, double least, double most);
  bool chance(double share);
  int whole(int low, int high);
  std::string word(std::initializer_list<const char*> words);
  std::string vector(double low, double high);
  /// Keys of a value or three that change within the run.
  std::string keys(double low, double high, bool three);
  /// What `text` draws, with that chance: from other numbers, so that the rest of the scene stays as it is.
  template <class Text>
  std::string drawn_by(std::mt19937_64& numbers, double share, const Text& text);
  template <class Text>
  std::string sometimes(double share, const Text& text);

  void begin();
  void fluid();
  void cloths();
  void cloth(int number, int count);
  /// Of the solute in a source's liquid.
  std::string concentration();
  std::string pins(int nx, int nz);
  std::string porous();
  /// The key `porous` with a film or with pores that pressure closes.
  std::string filmed_or_squeezed(std::string pores, bool still);
  /// By numbers of their own. `pores`: the cloth's key `porous`, if it has one.
  std::string regions(double thickness, const std::string& pores);
  /// One half of the last sheet or both, cut through its middle: each has a triangle at least.
  std::string halves(double thickness, const std::string& pores);
  void bodies();
  void air();
  void rotating_frame();
  std::string motion();

  std::mt19937_64 random_, more_, dyes_, patches_, others_, newest_, latest_, porous_, sprays_;
  bool narrow_;
  RandomScene drawn_;
  bool wild_ = false;                         // values anywhere in their ranges
  bool moving_pins_ = false, drips_ = false;  // has a cloth more than it holds?
  double d_ = 0.01, dt_ = 0.004, height_ = 0;
};

}  // namespace drench::test
