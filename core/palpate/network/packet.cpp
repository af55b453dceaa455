#include "palpate/network/packet.hpp"

#include <bit>
#include <cmath>
#include <cstring>

namespace palpate::network {
namespace {

constexpr double kLargest = 1e9;  // larger numbers are refused
constexpr double kReach = 100.0;  // [m] larger positions are refused

static_assert(std::endian::native == std::endian::little, "the layout is that of the memory");

/// Writes or reads the fields in order; both directions share one list, so that they cannot differ.
template <bool kReads>
class Cursor {
 public:
  explicit Cursor(std::uint8_t* at) noexcept : at_(at) {}
  template <class Stored, class T>
  void field(T& value) noexcept {
    Stored stored{};
    if constexpr (kReads) {
      std::memcpy(&stored, at_, sizeof stored);
      value = static_cast<T>(stored);
      if constexpr (std::is_floating_point_v<Stored>) good_ &= std::abs(value) < kLargest;  // false for NaN
    } else {
      stored = static_cast<Stored>(value);
      std::memcpy(at_, &stored, sizeof stored);
    }
    at_ += sizeof stored;
  }
  void vector(Vec3& x) noexcept {
    for (int i = 0; i < 3; ++i) field<float>(x[i]);
  }
  [[nodiscard]] bool good() const noexcept { return good_; }

 private:
  std::uint8_t* at_;
  bool good_ = true;
};

template <bool kReads>
bool transfer(Cursor<kReads> c, Datagram& d, Eigen::Quaterniond& q, std::uint32_t& version) noexcept {
  c.template field<std::uint32_t>(version);
  for (double* x : {&d.t, &d.t_peer, &d.t_received, &d.energy_in, &d.energy_out, &d.play_delay}) {
    c.template field<double>(*x);
  }
  c.vector(d.X.p);
  for (double* x : {&q.x(), &q.y(), &q.z(), &q.w()}) c.template field<float>(*x);
  c.vector(d.v);
  c.template field<float>(d.jaw);
  c.vector(d.F);
  c.vector(d.model.shift);
  ModelEstimate& m = d.model;
  for (double* x : {&m.K, &m.B, &m.mu, &m.sd_K, &m.sd_shift, &m.margin}) c.template field<float>(*x);
  c.vector(m.normal);
  double unused = 0.0;
  c.template field<float>(unused);
  c.template field<std::uint32_t>(d.flags);
  c.template field<std::uint32_t>(m.object);
  std::uint32_t zero = 0;
  c.template field<std::uint32_t>(zero);
  return c.good();
}

}  // namespace

Bytes encode(const Datagram& datagram) noexcept {
  Bytes bytes{};
  Datagram copy = datagram;
  Eigen::Quaterniond q(datagram.X.R);
  std::uint32_t version = kVersion;
  transfer(Cursor<false>(bytes.data()), copy, q, version);
  return bytes;
}

bool decode(std::span<const std::uint8_t> bytes, Datagram& out) noexcept {
  if (bytes.size() != kPacketSize) return false;
  Bytes copy;
  std::memcpy(copy.data(), bytes.data(), copy.size());
  Datagram d;
  Eigen::Quaterniond q;
  std::uint32_t version = 0;
  if (!transfer(Cursor<true>(copy.data()), d, q, version) || version != kVersion) return false;
  if (!(d.X.p.array().abs() < kReach).all() || !(d.model.shift.array().abs() < kReach).all()) return false;
  if (std::abs(q.norm() - 1.0) > 1e-3 || d.model.K < 0.0 || d.model.B < 0.0 || d.model.mu < 0.0) return false;
  const double length = d.model.normal.norm();
  if (length != 0.0 && std::abs(length - 1.0) > 1e-3) return false;
  if (length != 0.0) d.model.normal /= length;
  d.X.R = q.normalized().toRotationMatrix();
  out = d;
  return true;
}

}  // namespace palpate::network
