#include "palpate/reference/all_terms.hpp"

#include <pinocchio/algorithm/compute-all-terms.hpp>

#include "palpate/arm/chain.hpp"

namespace palpate::reference {

using arm::Chain;
using arm::FixedFrame;
using arm::Link;

namespace {

using ConstRef = Eigen::Ref<const Eigen::VectorXd>;  // the type Pinocchio's library is instantiated for

pinocchio::SE3 to_se3(const Pose& X) { return {X.R, X.p}; }

pinocchio::JointModel joint_model(const Link& link) {
  if (link.prismatic) return pinocchio::JointModelPrismaticUnaligned(link.axis);
  if (link.axis == Vec3::UnitZ()) return pinocchio::JointModelRZ();
  return pinocchio::JointModelRevoluteUnaligned(link.axis);
}

pinocchio::Model model_of(const Chain& chain) {
  pinocchio::Model model;
  pinocchio::JointIndex parent = 0;
  for (std::size_t k = 0; k < chain.links.size(); ++k) {
    const Link& link = chain.links[k];
    parent = model.addJoint(parent, joint_model(link), to_se3(link.X_parent), chain.facts.joint_names[k]);
    model.appendBodyToJoint(parent, pinocchio::Inertia(link.mass, link.com, link.inertia));
  }
  return model;
}

}  // namespace

struct AllTerms::Impl {
  explicit Impl(const Chain& chain) : tip(chain.tip), model(model_of(chain)), data(model) {}
  FixedFrame tip;
  pinocchio::Model model;
  pinocchio::Data data;
};

AllTerms::AllTerms(const std::string& xml, const std::string& base_frame, const std::string& tip_frame)
    : impl_(std::make_unique<Impl>(arm::chain_from_urdf(xml, base_frame, tip_frame))) {}
AllTerms::AllTerms(AllTerms&&) noexcept = default;
AllTerms& AllTerms::operator=(AllTerms&&) noexcept = default;
AllTerms::~AllTerms() = default;

Eigen::Index AllTerms::n() const noexcept { return impl_->model.nv; }

void AllTerms::compute(const Eigen::VectorXd& q, const Eigen::VectorXd& v) noexcept {
  pinocchio::computeAllTerms(impl_->model, impl_->data, ConstRef(q), ConstRef(v));
}

Eigen::MatrixXd AllTerms::M() const {
  return impl_->data.M.selfadjointView<Eigen::Upper>();  // the lower triangle is not filled
}
Eigen::VectorXd AllTerms::bias() const { return impl_->data.nle; }
Eigen::VectorXd AllTerms::G() const { return impl_->data.g; }

Eigen::MatrixXd AllTerms::J() const {
  const auto& X = impl_->data.oMi[static_cast<std::size_t>(impl_->tip.link) + 1];
  const Vec3 p = X.rotation() * impl_->tip.X_link.p + X.translation();
  Eigen::MatrixXd J = impl_->data.J;  // velocities of the point at the base's origin
  for (Eigen::Index k = 0; k < J.cols(); ++k) {
    const Vec3 w = J.col(k).tail<3>();
    J.col(k).head<3>() += w.cross(p);
  }
  return J;
}

}  // namespace palpate::reference
