#include "curve_table.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "kernels.hpp"

namespace glenoid {
namespace {

constexpr double kLeastRaised = 0x1p-10;  // 1 + c, theta = 177.5 deg; the curve has a kink at the arm straight up
constexpr int kPerOctave = 4;             // panels; a singularity at the end of the side is then 9 half widths away

/// cos(m pi / 20), the angles of ten Chebyshev nodes. Literals, for a compiler may evaluate std::cos of a constant itself and
/// round it otherwise than another one: the bits of every path would then be those of the compiler.
double cosine_of_twentieths(std::size_t m) {
  constexpr std::array<double, 11> kCosine = {1.0,
                                              0.98768834059513772619,
                                              0.95105651629515357212,
                                              0.89100652418836786236,
                                              0.80901699437494742410,
                                              0.70710678118654752440,
                                              0.58778525229247312917,
                                              0.45399049973954679156,
                                              0.30901699437494742410,
                                              0.15643446504023086901,
                                              0.0};
  m %= 40;
  if (m > 20) m = 40 - m;
  return m <= 10 ? kCosine[m] : -kCosine[20 - m];
}

/// cos(k (i + 1/2) pi / N): Chebyshev polynomial k at node i.
template <std::size_t N>
std::array<std::array<double, N>, N> chebyshev_at_nodes() {
  static_assert(N == 10);
  std::array<std::array<double, N>, N> table;
  for (std::size_t k = 0; k < N; ++k) {
    for (std::size_t i = 0; i < N; ++i) table[k][i] = cosine_of_twentieths(k * (2 * i + 1));
  }
  return table;
}

/// Coefficients in powers of t of the polynomial through Chebyshev nodes. value[i] belongs to cos((i + 1/2) pi / N).
template <std::size_t N>
void monomials(const double (&value)[N], double (&out)[N]) {
  static const auto kChebyshev = chebyshev_at_nodes<N>();
  double before[N] = {}, now[N] = {}, next[N] = {};  // Chebyshev polynomials of degree k - 1, k, k + 1
  now[0] = 1.0;
  for (double& c : out) c = 0.0;
  for (std::size_t k = 0; k < N; ++k) {
    double sum = 0.0;
    for (std::size_t i = 0; i < N; ++i) sum += kChebyshev[k][i] * value[i];
    const double weight = (k == 0 ? 1.0 : 2.0) / N;
    for (std::size_t j = 0; j < N; ++j) out[j] += weight * sum * now[j];
    for (std::size_t j = 0; j < N; ++j) {
      next[j] = (k == 0 ? 1.0 : 2.0) * (j > 0 ? now[j - 1] : 0.0) - before[j];
    }
    for (std::size_t j = 0; j < N; ++j) before[j] = now[j], now[j] = next[j];
  }
}

}  // namespace

CurveTable::CurveTable(double scale, const Curve& curve) {
  hanging_.end = 1.0;
  raised_.end = -1.0;
  const double least = std::scalbn(1.0, std::ilogb(scale));
  tip_ = fit(0.0, least, 1.0, curve);
  fill(hanging_, least, curve);
  fill(raised_, kLeastRaised, curve);
}

/// Counts panels: kPerOctave for each power of two, found in the leading bits of the number.
int CurveTable::key(double v) noexcept {
  static_assert(kPerOctave == 4);
  std::uint64_t bits = 0;  // no std::bit_cast: importers that build FMI 2.0 sources take their compiler's default, C++17
  std::memcpy(&bits, &v, sizeof bits);
  return static_cast<int>(bits >> 50);
}

void CurveTable::fill(Side& side, double least, const Curve& curve) {
  side.first = key(least);
  for (double octave = least; octave <= 1.0; octave *= 2.0) {
    // of the last octave only the panel that begins at v = 1, and that only for its lower end
    const int count = octave < 1.0 ? kPerOctave : 1;
    for (int k = 0; k < count; ++k) {
      const double width = octave / kPerOctave;
      side.panels.push_back(fit(octave + k * width, octave + (k + 1) * width, side.end, curve));
    }
  }
}

/// The second derivative is interpolated and integrated twice, so that it does not suffer from the rounding of the value.
CurveTable::Panel CurveTable::fit(double low, double high, double end, const Curve& curve) {
  constexpr std::size_t kNodes = kDegree - 1;
  Panel p{};
  p.middle = 0.5 * (low + high);
  const double half = 0.5 * (high - low);
  p.reciprocal = 1.0 / half;
  CurveJet jets[kNodes];
  for (std::size_t i = 0; i < kNodes; ++i) {
    const double t = cosine_of_twentieths(2 * i + 1);
    jets[i] = curve(end * (1.0 - (p.middle + half * t)));
  }
  const CurveJet middle = curve(end * (1.0 - p.middle));
  for (int r = 0; r < 3; ++r) {
    double second[kNodes], power[kNodes];
    for (std::size_t i = 0; i < kNodes; ++i) second[i] = jets[i].d2[r];
    monomials(second, power);
    p.a[0][r] = middle.x[r];
    p.a[1][r] = -end * half * middle.d1[r];
    for (std::size_t k = 0; k < kNodes; ++k) {
      p.a[k + 2][r] = half * half * power[k] / static_cast<double>((k + 1) * (k + 2));
    }
  }
  return p;
}

bool CurveTable::evaluate(double c, CurveJet& out) const noexcept {
  if (std::isnan(c)) return false;
  const Side& side = c < 0.0 ? raised_ : hanging_;
  const double v = 1.0 - side.end * c;
  const int index = key(v) - side.first;
  const Panel* panel = &tip_;
  if (index >= 0) {
    panel = &side.panels[static_cast<std::size_t>(index)];
  } else if (c < 0.0) {
    return false;
  }
  alignas(32) double jet[3][4];
  power_series(panel->a, kDegree, (v - panel->middle) * panel->reciprocal, jet);
  const double rate = -side.end * panel->reciprocal, square = panel->reciprocal * panel->reciprocal;
  for (int r = 0; r < 3; ++r) {
    out.x[r] = jet[0][r];
    out.d1[r] = rate * jet[1][r];
    out.d2[r] = square * jet[2][r];
  }
  return true;
}

}  // namespace glenoid
