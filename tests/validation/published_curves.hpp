#pragma once
// Published measurements of liquid in fabric and paper, with their sources and scatter: all that
// published_fabric_test.cpp compares with. Numbers alone, in SI units.

#include <array>
#include <vector>

namespace drench::test {

/// Heights of water over time in a strip that hangs into it.
struct WickingCurve {
  const char* knit;
  const char* fabric;             // its name in src/scene/fabrics.yaml
  std::array<double, 7> height;   // m: mean of nine strips at wicking_times
  std::array<double, 7> scatter;  // m: standard deviation of the nine
};

inline constexpr std::array<double, 7> wicking_times{30, 60, 120, 180, 300, 420, 600};  // s

/// W. Jasper, O. Tandel: Wicking Tracker, github.com/wjasper/Wicking_Tracker (2025, GPL-3.0), folder output, raw tables
/// data.csv of the indoor runs `108 Nylon F1…F9`, `108 Nylon T1…T9`, `108 Polyester F1…F9`, `108 Polyester T1…T9` and
/// `200 Polyester F1…F9` of July 2025, `144 Nylon F1…F9` of 30 June and 1 July, `144 Nylon T1-0628…T9-0628` of 28 June.
/// F is a flat and T a terry knit of socks, the number that of the machine's needles. Before 30 s their camera lags.
inline constexpr std::array<WickingCurve, 7> sock_curves{{{"flat nylon, 108 needles",
                                                           "sock_nylon",
                                                           {0.0341, 0.0427, 0.0530, 0.0597, 0.0706, 0.0779, 0.0849},
                                                           {0.0010, 0.0011, 0.0010, 0.0009, 0.0009, 0.0010, 0.0007}},
                                                          {"terry nylon, 108 needles",
                                                           "sock_nylon_terry",
                                                           {0.0327, 0.0411, 0.0510, 0.0577, 0.0689, 0.0761, 0.0834},
                                                           {0.0008, 0.0009, 0.0009, 0.0010, 0.0009, 0.0011, 0.0014}},
                                                          {"flat polyester, 108 needles",
                                                           "sock_polyester",
                                                           {0.0358, 0.0438, 0.0526, 0.0586, 0.0685, 0.0744, 0.0809},
                                                           {0.0015, 0.0015, 0.0010, 0.0014, 0.0011, 0.0013, 0.0009}},
                                                          {"terry polyester, 108 needles",
                                                           "sock_polyester_terry",
                                                           {0.0333, 0.0406, 0.0500, 0.0561, 0.0664, 0.0725, 0.0791},
                                                           {0.0009, 0.0008, 0.0010, 0.0012, 0.0015, 0.0015, 0.0016}},
                                                          {"flat polyester, 200 needles",
                                                           "sock_polyester_200",
                                                           {0.0435, 0.0560, 0.0710, 0.0843, 0.1001, 0.1135, 0.1292},
                                                           {0.0011, 0.0013, 0.0021, 0.0019, 0.0019, 0.0017, 0.0019}},
                                                          {"flat nylon, 144 needles",
                                                           "sock_nylon_144",
                                                           {0.0436, 0.0565, 0.0716, 0.0814, 0.0972, 0.1115, 0.1271},
                                                           {0.0047, 0.0042, 0.0042, 0.0047, 0.0058, 0.0057, 0.0054}},
                                                          {"terry nylon, 144 needles",
                                                           "sock_nylon_144_terry",
                                                           {0.0371, 0.0480, 0.0617, 0.0705, 0.0840, 0.0965, 0.1108},
                                                           {0.0019, 0.0021, 0.0024, 0.0024, 0.0028, 0.0026, 0.0022}}}};

/// Saturation over the similarity variable x/√t.
struct ProfilePoint {
  double o;           // m/√s
  double saturation;  // 1
  double scatter;     // 1: standard deviation; 0: not given
};

/// Water drawn along a strip without gravity, from an end that is kept full.
struct Imbibition {
  const char *sheet, *reference;
  double front;     // m/√s: where the saturation is 1/2
  double absorbed;  // m/√s: the integral of the saturation
  std::vector<ProfilePoint> profile;
};

/// Gerlero, Valdez, Urteaga, Kler: Validity of capillary imbibition models in paper-based microfluidic applications.
/// Transp. Porous Media 141, 359 (2022). Every seventh of the 141 points of the authors' data
/// (github.com/gerlero/frontx, examples/data/validity), closer at the front; front and absorbed are of all points.
inline const Imbibition paper{
    "filter paper",
    "Gerlero et al. 2022, measured profile",
    2.044e-3,
    2.00e-3,
    {{0.30507e-3, 1.0024, 0.0021}, {0.41135e-3, 1.0019, 0.0017}, {0.51763e-3, 1.0006, 0.0023},
     {0.62390e-3, 1.0000, 0.0012}, {0.73018e-3, 0.9986, 0.0008}, {0.83646e-3, 0.9983, 0.0010},
     {0.94274e-3, 0.9966, 0.0014}, {1.04900e-3, 0.9957, 0.0019}, {1.15530e-3, 0.9941, 0.0026},
     {1.26160e-3, 0.9906, 0.0027}, {1.36780e-3, 0.9893, 0.0028}, {1.47410e-3, 0.9869, 0.0033},
     {1.58040e-3, 0.9758, 0.0056}, {1.68670e-3, 0.9528, 0.0087}, {1.79300e-3, 0.9154, 0.0114},
     {1.89920e-3, 0.8521, 0.0127}, {2.00550e-3, 0.7077, 0.0306}, {2.02070e-3, 0.6563, 0.0365},
     {2.05110e-3, 0.4395, 0.0434}, {2.08140e-3, 0.1971, 0.0438}, {2.11180e-3, 0.0850, 0.0392},
     {2.14220e-3, 0.0374, 0.0290}, {2.17250e-3, 0.0200, 0.0154}, {2.21810e-3, 0.0078, 0.0043}}};

/// J. R. Buser, thesis of 2016, hdl.handle.net/1773/38064: a nitrocellulose membrane HF135. Its fitted coefficients
/// alone could be read, as the examples of github.com/gerlero/fronts quote them: van Genuchten's law with k = 5.5e-13
/// m², α = 0.2555 1/m, n = 2.3521, water content 0.0473 to 0.945, 0.102755 at the start. The curve is Richards'
/// equation with them, solved by the package fronts.
inline const Imbibition membrane{"a nitrocellulose membrane",
                                 "Buser 2016, curve of the fitted coefficients",
                                 5.238e-3,
                                 4.881e-3,
                                 {{0.5238e-3, 0.999, 0},
                                  {1.0475e-3, 0.997, 0},
                                  {1.5713e-3, 0.991, 0},
                                  {2.6188e-3, 0.964, 0},
                                  {3.6663e-3, 0.898, 0},
                                  {4.1901e-3, 0.833, 0},
                                  {4.7138e-3, 0.723, 0}}};

}  // namespace drench::test
