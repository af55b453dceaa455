#include "palpate/arm/serial.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/arm/chain.hpp"
#include "palpate/arm/recursion.hpp"

namespace palpate::arm {
namespace {

constexpr Eigen::Index kMoments = 4;      // of a link: m, m c
constexpr Eigen::Index kParameters = 10;  // of a link: m, m c, I about the joint's origin: xx, xy, yy, xz, yz, zz
using Inertial = Eigen::Matrix<double, kParameters, 1>;

Mat3 cross_matrix(const Vec3& a) noexcept {
  Mat3 A;
  A << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return A;
}

Inertial parameters_of(const Link& link) noexcept {
  const Mat3 C = cross_matrix(link.com);
  const Mat3 I = link.inertia - link.mass * (C * C);
  Inertial pi;
  pi << link.mass, link.mass * link.com, I(0, 0), I(0, 1), I(1, 1), I(0, 2), I(1, 2), I(2, 2);
  return pi;
}

void set_parameters(const Inertial& pi, Link& link) noexcept {
  link.mass = pi[0];
  link.com = pi.segment<3>(1) / pi[0];
  const Mat3 C = cross_matrix(link.com);
  Mat3 I;
  I << pi[4], pi[5], pi[7], pi[5], pi[6], pi[8], pi[7], pi[8], pi[9];
  link.inertia = I + link.mass * (C * C);
}

/// L(a) of I a = L(a) (I_xx, I_xy, I_yy, I_xz, I_yz, I_zz).
Eigen::Matrix<double, 3, 6> of_inertia(const Vec3& a) noexcept {
  Eigen::Matrix<double, 3, 6> L;
  L << a.x(), a.y(), 0.0, a.z(), 0.0, 0.0,  //
      0.0, a.x(), a.y(), 0.0, a.z(), 0.0,   //
      0.0, 0.0, 0.0, a.x(), a.y(), a.z();
  return L;
}

/// Axes whose z is the joint's axis, in the link's axes; the identity for an axis along z.
Mat3 turned_to(const Vec3& axis) noexcept {
  if (axis == Vec3::UnitZ()) return Mat3::Identity();
  const Vec3 side = std::abs(axis.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 y = axis.cross(side).normalized();
  Mat3 Q;
  Q << y.cross(axis), y, axis;
  return Q;
}

class Serial final : public Mechanism {
 public:
  explicit Serial(Chain chain) : chain_(std::move(chain)) {
    lanes_.n = static_cast<int>(chain_.links.size());
    set_gravity({0.0, 0.0, -9.81});
    for (int k = 0; k < lanes_.n; ++k) turned_.push_back(turned_to(link(k).axis));
    for (int k = 0; k < lanes_.n; ++k) take_joint(k);
    turn(chain_.tip);
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) lanes_.tip[j][i] = chain_.tip.X_link.R(i, j);
      lanes_.tip[3][i] = chain_.tip.X_link.p[i];
    }
    for (FixedFrame& frame : chain_.frames) turn(frame);
    take_masses();
  }
  Serial(const Serial&) = default;
  [[nodiscard]] std::unique_ptr<Mechanism> clone() const override { return std::make_unique<Serial>(*this); }
  [[nodiscard]] const Facts& facts() const noexcept override { return chain_.facts; }
  [[nodiscard]] const ChainLanes& constants() const noexcept { return lanes_; }

  void kinematics(const JointVector& q, Pose& X_0T, Jacobian& J) noexcept override {
    arm::kinematics(lanes_, lanes(q), now_);
    tip(X_0T, J);
  }

  void dynamics(const JointVector& q, const JointVector& v, Dynamics& d) noexcept override {
    arm::dynamics(lanes_, lanes(q), lanes(v), zero_, {}, now_);
    tip(d.X_0T, d.J);
    const int n = lanes_.n;
    d.M.resize(n, n);
    d.bias.resize(n);
    d.G.resize(n);
    double* M = d.M.data();
    for (int k = 0; k < n; ++k) {
      for (int i = 0; i < n; ++i) M[k * n + i] = now_.M[k][i];
      d.bias[k] = now_.bias[k];
      d.G[k] = now_.G[k];
    }
    std::copy_n(now_.Jdot_v, 3, d.Jdot_v.data());
    std::copy_n(now_.Jdot_v + 4, 3, d.Jdot_v.data() + 3);
  }

  const LaneDynamics& lane_dynamics(const JointVector& q, const JointVector& v, const TipBody& body,
                                    LaneDynamics& /*work*/) noexcept override {
    arm::dynamics(lanes_, lanes(q), lanes(v), zero_, body, now_);
    return now_;
  }

  void inverse_dynamics(const JointVector& q, const JointVector& v, const JointVector& a, Dynamics& /*work*/,
                        JointVector& tau) noexcept override {
    arm::dynamics(lanes_, lanes(q), lanes(v), lanes(a), {}, now_);
    tau.resize(lanes_.n);
    for (int k = 0; k < lanes_.n; ++k) tau[k] = now_.bias[k];
  }

  /// Joint j moves the point p of a link with v0_j + w_j x p; P = -g . sum (m p_k + R_k m c_k).
  void gravity_regressor(const JointVector& q, GravityRegressor& out) noexcept override {
    arm::kinematics(lanes_, lanes(q), now_);
    const Vec3 g = gravity();
    const int n = lanes_.n;
    out.Y.setZero(n, kMoments * n);
    out.P.resize(kMoments * n);
    for (int k = 0; k < n; ++k) {
      const Pose X = pose(k);
      const Vec3 g_link = X.R.transpose() * g;
      out.P[kMoments * k] = -g.dot(X.p);
      out.P.segment<3>(kMoments * k + 1) = -g_link;
      for (int j = 0; j <= k; ++j) {
        const Vec3 w = lane<3>(now_.Jw, j), v0 = lane<3>(now_.Jv, j);
        out.Y(j, kMoments * k) = -g.dot(v0 + w.cross(X.p));
        out.Y.block<1, 3>(j, kMoments * k + 1) = -X.R.transpose() * g.cross(w);
      }
    }
  }

  [[nodiscard]] Eigen::VectorXd moments() const override {
    Eigen::VectorXd Pi(kMoments * lanes_.n);
    for (int k = 0; k < lanes_.n; ++k) Pi.segment<4>(kMoments * k) << link(k).mass, link(k).mass * link(k).com;
    return Pi;
  }

  [[nodiscard]] double potential_energy(const JointVector& q) noexcept override {
    arm::kinematics(lanes_, lanes(q), now_);
    double P = 0.0;
    for (int k = 0; k < lanes_.n; ++k) P -= link(k).mass * gravity().dot(pose(k) * link(k).com);
    return P;
  }

  void set_gravity(const Vec3& g_base) noexcept override {
    for (int i = 0; i < 3; ++i) lanes_.g[i] = g_base[i];
  }

  void scale_masses(const JointVector& scale) override {
    for (int k = 0; k < lanes_.n; ++k) {
      link(k).mass *= scale[k];
      link(k).inertia *= scale[k];
    }
    take_masses();
  }

  [[nodiscard]] Pose link_pose(int index) const noexcept override {
    return frame_pose(chain_.frames[static_cast<std::size_t>(index)]);
  }

  /// Force and moment that a link's motion requires about its joint's origin, in the link's axes, are linear in its ten
  /// parameters. They load all joints before the link.
  [[nodiscard]] Eigen::MatrixXd torque_regressor(const JointVector& q, const JointVector& v,
                                                 const JointVector& a) override {
    arm::dynamics(lanes_, lanes(q), lanes(v), lanes(a), {}, now_);
    const int n = lanes_.n;
    Eigen::MatrixXd Y = Eigen::MatrixXd::Zero(n, kParameters * n);
    for (int k = 0; k < n; ++k) {
      const Pose X = pose(k);
      const Vec3 v0 = lane<3>(now_.V, k), w0 = lane<3>(now_.V + 3, k);
      const Vec3 a0 = lane<3>(now_.A, k), alpha0 = lane<3>(now_.A + 3, k);
      const Vec3 w = X.R.transpose() * w0, alpha = X.R.transpose() * alpha0;
      const Vec3 a_origin = X.R.transpose() * (a0 + alpha0.cross(X.p) + w0.cross(v0 + w0.cross(X.p)));
      Eigen::Matrix<double, 3, 10> f = Eigen::Matrix<double, 3, 10>::Zero(), t = f;
      f.col(0) = a_origin;
      f.middleCols<3>(1) = cross_matrix(alpha) + cross_matrix(w) * cross_matrix(w);
      t.middleCols<3>(1) = -cross_matrix(a_origin);
      t.rightCols<6>() = of_inertia(alpha) + cross_matrix(w) * of_inertia(w);
      for (int j = 0; j <= k; ++j) {
        const Vec3 w_j = lane<3>(now_.Jw, j), v_j = lane<3>(now_.Jv, j) + w_j.cross(X.p);
        const Vec3 v_link = X.R.transpose() * v_j, w_link = X.R.transpose() * w_j;
        for (Eigen::Index i = 0; i < kParameters; ++i) {
          Y(j, kParameters * k + i) = v_link.dot(f.col(i)) + w_link.dot(t.col(i));
        }
      }
    }
    return Y;
  }

  [[nodiscard]] Eigen::VectorXd inertial_parameters() const override {
    Eigen::VectorXd pi(kParameters * lanes_.n);
    for (int k = 0; k < lanes_.n; ++k) pi.segment<10>(kParameters * k) = parameters_of(link(k));
    return pi;
  }

  void set_inertial_parameters(const Eigen::VectorXd& pi) override {
    for (int k = 0; k < lanes_.n; ++k) set_parameters(pi.segment<10>(kParameters * k), link(k));
    take_masses();
  }

 private:
  [[nodiscard]] Link& link(int k) { return chain_.links[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const Link& link(int k) const { return chain_.links[static_cast<std::size_t>(k)]; }
  [[nodiscard]] Vec3 gravity() const noexcept { return {lanes_.g[0], lanes_.g[1], lanes_.g[2]}; }

  /// The numbers of joint k.
  template <int rows>
  [[nodiscard]] static Eigen::Matrix<double, rows, 1> lane(const Lanes* lanes, int k) noexcept {
    Eigen::Matrix<double, rows, 1> x;
    for (int i = 0; i < rows; ++i) x[i] = lanes[i][k];
    return x;
  }

  /// Pose of link k in its turned axes; -1: the base.
  [[nodiscard]] Pose turned_pose(int k) const noexcept {
    if (k < 0) return {};
    Pose X;
    for (int i = 0; i < 9; ++i) X.R.data()[i] = now_.R[i][k];
    X.p = lane<3>(now_.p, k);
    return X;
  }
  /// X_0k of link k.
  [[nodiscard]] Pose pose(int k) const noexcept {
    const Pose X = turned_pose(k);
    return {X.R.lazyProduct(turned_[static_cast<std::size_t>(k)].transpose()), X.p};
  }
  /// Pose of a frame whose X_link refers to the turned axes.
  [[nodiscard]] Pose frame_pose(const FixedFrame& frame) const noexcept {
    const Pose X = turned_pose(frame.link);
    return {X.R.lazyProduct(frame.X_link.R), X.R.lazyProduct(frame.X_link.p) + X.p};
  }

  void turn(FixedFrame& frame) const noexcept {
    if (frame.link < 0) return;
    const Mat3& Q = turned_[static_cast<std::size_t>(frame.link)];
    frame.X_link = {Q.transpose() * frame.X_link.R, Q.transpose() * frame.X_link.p};
  }

  /// The tip's pose and Jacobian.
  void tip(Pose& X_0T, Jacobian& J) const noexcept {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) X_0T.R.data()[3 * j + i] = now_.tip[j][i];
      X_0T.p[i] = now_.tip[3][i];
    }
    J.resize(6, lanes_.n);
    double* column = J.data();
    for (int k = 0; k < lanes_.n; ++k, column += 6) {
      for (int r = 0; r < 6; ++r) column[r] = now_.J[r][k];
    }
  }

  void take_joint(int k) noexcept {
    const Mat3& Q = turned_[static_cast<std::size_t>(k)];
    const Mat3 Q_parent = k > 0 ? turned_[static_cast<std::size_t>(k) - 1] : Mat3(Mat3::Identity());
    const Mat3 R = Q_parent.transpose() * link(k).X_parent.R * Q;
    const Vec3 p = Q_parent.transpose() * link(k).X_parent.p;
    for (int i = 0; i < 9; ++i) lanes_.R[i][k] = R.data()[i];
    for (int i = 0; i < 3; ++i) lanes_.p[i][k] = p[i];
    (link(k).prismatic ? lanes_.slides : lanes_.turns)[k] = 1.0;
    (link(k).prismatic ? lanes_.prismatic : lanes_.revolute)[k] = lanes_.joints[k] = -1;
  }

  void take_masses() noexcept {
    for (int k = 0; k < lanes_.n; ++k) {
      const Mat3& Q = turned_[static_cast<std::size_t>(k)];
      const Mat3 I = Q.transpose() * link(k).inertia * Q;
      const Vec3 com = Q.transpose() * link(k).com;
      const double six[6] = {I(0, 0), I(0, 1), I(1, 1), I(0, 2), I(1, 2), I(2, 2)};
      lanes_.m[k] = link(k).mass;
      for (int i = 0; i < 3; ++i) lanes_.c[i][k] = com[i];
      for (int i = 0; i < 6; ++i) lanes_.I[i][k] = six[i];
    }
    double carried = 0.0;
    for (int k = lanes_.n - 1; k >= 0; --k) lanes_.m_carried[k] = carried += link(k).mass;
  }

  Chain chain_;               ///< its frames refer to the turned axes
  std::vector<Mat3> turned_;  ///< for each link, its axes in ChainLanes as seen from its own axes
  ChainLanes lanes_;
  ChainState now_;
  Lanes zero_{};
};

}  // namespace

std::unique_ptr<Mechanism> serial_arm(const std::string& xml, const std::string& base_frame,
                                      const std::string& tip_frame) {
  return std::make_unique<Serial>(chain_from_urdf(xml, base_frame, tip_frame));
}

ChainLanes chain_lanes(const std::string& xml, const std::string& base_frame, const std::string& tip_frame) {
  return Serial(chain_from_urdf(xml, base_frame, tip_frame)).constants();
}

}  // namespace palpate::arm
