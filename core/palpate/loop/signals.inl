// The table of signals: every row is one field of `struct Tick` and one recorded channel. tick.hpp builds the struct
// from it, and tick.cpp the list that record, report, viewer and numpy read.
//
//   SIGNAL(stage, type, name, unit, frame, meaning, deterministic)
//
// stage: producer of the signal, the first word of its channel. frame: monogram letter of the frame in which it is
// expressed, or empty. deterministic: false if the value depends on the machine; a lockstep record omits such a signal.

// clang-format off
SIGNAL(loop, double, t, "s", "", "time of the tick", true)
SIGNAL(stability, Bits, status, "bits", "", "status of the safety layer, by bits (docs/stability.md)", true)
SIGNAL(loop, Reals<3>, cause, "1", "",
       "newest fault of a device on a network: number of its status bit, two values", true)
SIGNAL(leader, Reals<7>, q, "rad", "", "leader joints, measured", true)
SIGNAL(leader, Reals<7>, v, "rad/s", "", "leader joint velocities, estimated", true)
SIGNAL(torque, Reals<7>, tau, "N m", "", "commanded joint torque, the sum of its terms", true)
SIGNAL(torque, Reals<7>, tau_force, "N m", "", "joint torque that renders the force: J^T (F_H_L + F_law_L)", true)
SIGNAL(torque, Reals<7>, tau_gravity, "N m", "", "joint torque of gravity compensation, G_hat(q)", true)
SIGNAL(torque, Reals<7>, tau_platform, "N m", "", "joint torque of the controller of joint 4 in the null space", true)
SIGNAL(torque, Reals<7>, tau_friction, "N m", "", "joint torque that compensates the arm's friction", true)
SIGNAL(torque, Reals<7>, tau_limits, "N m", "", "joint torque of the soft stops before the joint limits", true)
SIGNAL(torque, Reals<3>, F_law_L, "N", "L", "force that the control law adds to F_H_L at the handle", true)
SIGNAL(torque, double, F_neglected, "N", "", "inertia and Coriolis force that the control law leaves to the hand", true)
SIGNAL(leader, double, gripper, "rad", "", "pinch angle of the leader", true)
SIGNAL(leader, Reals<3>, p_LH, "m", "L", "handle position", true)
SIGNAL(leader, Reals<4>, quat_LH, "1", "L", "handle orientation, w x y z", true)
SIGNAL(leader, Reals<3>, v_LH, "m/s", "L", "handle velocity", true)
SIGNAL(follower, Reals<7>, q_follower, "rad|m", "", "follower joints, measured", true)
SIGNAL(follower, Reals<7>, q_follower_goal, "rad|m", "", "follower joints, commanded", true)
SIGNAL(follower, Reals<7>, tau_follower, "N m|N", "", "torques of the follower's drives, where they are measured", true)
SIGNAL(follower, double, jaw, "rad", "", "jaw angle of the follower", true)
SIGNAL(mapping, double, jaw_goal, "rad", "", "jaw angle from the mapping of the pinch angle", true)
SIGNAL(force, double, tau_jaw, "N m", "", "torque of the contacts on the jaws, positive when it opens them", true)
SIGNAL(stability, double, tau_gripper, "N m", "",
       "torque commanded on the operator's fingers, positive when it opens them", true)
SIGNAL(mapping, Reals<3>, p_WT_goal, "m", "W", "tool goal from the mapping, corrected by hard fixtures", true)
SIGNAL(mapping, Reals<3>, p_shift_W, "m", "W",
       "shift of the tool against the hand that pauses after faults caused", true)
SIGNAL(follower, Reals<3>, p_WT, "m", "W", "tool tip x, measured", true)
SIGNAL(follower, Reals<4>, quat_WT, "1", "W", "tool orientation, w x y z", true)
SIGNAL(contact, Reals<3>, p_WP, "m", "W", "proxy x_d; the tool tip when nothing is touched", true)
SIGNAL(contact, Reals<3>, normal, "1", "W", "surface normal, out of the obstacle; zero when free", true)
SIGNAL(contact, Reals<3>, delta_x, "m", "W", "deflection x_d - x, out of the obstacle", true)
SIGNAL(contact, double, depth, "m", "", "penetration: deflection along the normal", true)
SIGNAL(contact, double, contacts, "1", "", "number of touches: pairs of a sphere of the tool and an object", true)
SIGNAL(contact, Reals<kTouches>, touch_sphere, "1", "",
       "index of the sphere of each touch, the strongest first; 0 is the sphere on the tip", true)
SIGNAL(contact, Reals<kTouches>, touch_object, "1", "", "index of the object of each touch", true)
SIGNAL(contact, Reals<kTouches>, touch_force, "N", "", "spring force of each touch along its normal", true)
SIGNAL(contact, Reals<3 * kTouches>, p_WC, "m", "W", "point of each touch at which the proxy touches the surface", true)
SIGNAL(force, Reals<3>, F_T_W, "N", "W",
       "force of the environment on the tool by the force law, before the stability stage", true)
SIGNAL(force, Reals<3>, t_T_W, "N m", "W", "torque of F_T_W's contacts about the tool tip", true)
SIGNAL(force, Reals<3>, F_spring_W, "N", "W", "spring part of the force law, K delta_x", true)
SIGNAL(force, Reals<3>, F_damping_W, "N", "W", "damping part of the force law, -B xdot", true)
SIGNAL(force, Reals<3>, F_estimate_W, "N", "W",
       "force of the environment on the tool, estimated from the follower's drive torques", true)
SIGNAL(follower, Reals<3>, F_touch_W, "N", "W",
       "true force of objects on the tool of a driven follower (simulated)", true)
SIGNAL(guidance, Reals<3>, F_guidance_W, "N", "W", "force of the fixtures of guidance on the tool", true)
SIGNAL(guidance, Reals<3>, t_guidance_W, "N m", "W", "torque of the fixtures of guidance about the tool tip", true)
SIGNAL(guidance, double, guidance_fixture, "1", "", "index of the fixture that pulls most; -1 when none does", true)
SIGNAL(guidance, double, guidance_gap, "m|rad", "",
       "gap of the fixture that pulls most, or of the nearest one; negative where its constraint is violated", true)
SIGNAL(guidance, Reals<4>, quat_WT_asked, "1", "W",
       "goal of the tool's orientation before hard fixtures turn it, w x y z", true)
SIGNAL(guidance, Reals<3>, p_correction_W, "m", "W", "correction of the tool goal by hard fixtures", true)
SIGNAL(stability, Reals<3>, F_H_L, "N", "L", "force commanded on the hand, spatial frame", true)
SIGNAL(stability, Reals<3>, t_H_L, "N m", "L", "moment commanded on the hand, spatial frame", true)
SIGNAL(stability, Reals<3>, F_H_H, "N", "H", "force commanded on the hand, body frame", true)
SIGNAL(stability, Reals<3>, F_asked, "N", "",
       "magnitude of the force before the stability stage: in all, of contacts, of guidance", true)
SIGNAL(stability, Reals<kWithholders>, F_withheld, "N", "",
       "part of F_asked withheld by coupling, low-pass, passivity, force cap, rate cap, device, closed gate", true)
SIGNAL(hand, Reals<3>, F_cell_L, "N", "L", "load cell: force of the arm on the hand (simulated)", true)
SIGNAL(hand, Reals<3>, p_hand_L, "m", "L", "position to which the simulated operator pulls the hand", true)
SIGNAL(stability, double, energy_port, "J", "",
       "energy the rendered force took from the hand; below zero it generated", true)
SIGNAL(stability, double, energy_spring, "J", "", "energy stored in the contact springs and in soft bodies", true)
SIGNAL(stability, double, energy_damping, "J", "", "energy dissipated by the damping of the force law", true)
SIGNAL(stability, double, energy_mapping, "J", "",
       "energy released from the contact springs by motion of the mapping itself", true)
SIGNAL(stability, double, energy_cut, "J", "", "energy withheld by the caps", true)
SIGNAL(stability, double, energy_passivity, "J", "", "energy withheld by the passivity controller", true)
SIGNAL(stability, double, energy_low_pass, "J", "", "energy withheld by the low-pass filter", true)
SIGNAL(stability, double, energy_coupling, "J", "", "energy withheld by the virtual coupling", true)
SIGNAL(stability, Reals<kSources>, energy_source, "J", "",
       "energy of the force before the stability stage: of each object, of guidance, and last of all the rest", true)
SIGNAL(contact, double, tissue_potential, "J", "", "strain energy of soft bodies", true)
SIGNAL(contact, double, tissue_kinetic, "J", "", "kinetic energy of soft bodies", true)
SIGNAL(contact, double, tissue_status, "1", "",
       "status of soft bodies, a sum: 1 more time steps, 2 diverged, 4 thread late", true)
SIGNAL(stability, double, energy_stored, "J", "", "energy that the force may still return to the hand", true)
SIGNAL(stability, double, energy_lent, "J", "",
       "energy credited to the port for fixtures that were switched on, and not yet repaid", true)
SIGNAL(stability, double, energy_reserved, "J", "",
       "part of energy_stored that is kept for wrenches not yet applied", true)
SIGNAL(stability, Reals<4>, lag_ms, "ms", "",
       "time by which virtual coupling, low-pass filter, passivity controller and caps delay the force", true)
SIGNAL(tracking, Reals<3 * kMaxLive>, live_p, "m", "W",
       "position of each object that follows a tracker, as rendered, in the scene's order", true)
SIGNAL(tracking, Reals<4 * kMaxLive>, live_quat, "1", "W", "orientation of each tracked object, w x y z", true)
SIGNAL(tracking, Reals<kMaxLive>, live_share, "1", "",
       "share of its stiffness and damping with which each object that follows a tracker is rendered", true)
SIGNAL(tracking, Reals<3 * kMaxLive>, tracked_p, "m", "W",
       "last good position of each tracked frame, in the scene's order", true)
SIGNAL(tracking, Reals<4 * kMaxLive>, tracked_quat, "1", "W", "orientation of each tracked frame, w x y z", true)
SIGNAL(tracking, Reals<kMaxLive>, tracked_age, "s", "",
       "age of the pose of each tracked frame; infinite before the first", true)
SIGNAL(tracking, Reals<kMaxLive>, tracked_status, "1", "",
       "state of each tracked frame; 0: not seen yet, 1: tracked, 2: lost", true)
SIGNAL(loop, double, session_state, "1", "", "state of the session, by its number in docs/session.md", true)
SIGNAL(loop, double, execution, "1", "", "phase of the planned motion (docs/planning-execution.md); 0: none", true)
SIGNAL(loop, double, execution_motion, "1", "", "number of the planned motion", true)
SIGNAL(loop, double, execution_t, "s", "", "time along the planned motion", true)
SIGNAL(pairs, Reals<3>, F_instrument_W, "N", "W", "force of other instruments on the tool", true)
SIGNAL(pairs, Reals<3>, t_instrument_W, "N m", "W", "torque of other instruments about the tool tip", true)
SIGNAL(pairs, double, instrument_gap, "m", "",
       "smallest distance to another instrument, negative in contact", true)
SIGNAL(pairs, double, handle_gap, "m", "", "smallest distance to the handle of another leader", true)
SIGNAL(pairs, double, holding, "1", "",
       "hold of the jaws on the graspable object; 0: none, 1: they carry it, 2: beside those that carry it", true)
SIGNAL(pairs, Reals<3>, p_WO, "m", "W", "position of the graspable object", true)
SIGNAL(pairs, Reals<4>, quat_WO, "1", "W", "orientation of the graspable object, w x y z", true)
SIGNAL(pairs, Reals<3>, F_held_W, "N", "W", "force on the tool of the object that another instrument holds too", true)
SIGNAL(remote, Reals<3>, p_WR, "m", "W", "position of the remote tool by its newest packet; zero without a link", true)
SIGNAL(remote, Reals<3>, F_remote_W, "N", "W", "measured force on the remote tool, by its newest packet", true)
SIGNAL(remote, double, remote_age, "s", "", "age of the newest packet of the remote site", true)
SIGNAL(remote, double, remote_delay, "s", "", "time after which the remote tool is where the local one is now", true)
SIGNAL(remote, double, remote_link, "1", "",
       "state of the link; 0: no remote site, 1: down, and both sides hold, 2: up", true)
SIGNAL(remote, double, remote_received, "1", "", "number of packets that have arrived from the remote site", true)
SIGNAL(remote, double, energy_model, "J", "",
       "net energy that updates of the remote model added to the contact springs", true)
SIGNAL(remote, double, energy_tank, "J", "", "energy left for further updates of the remote model", true)
SIGNAL(loop, double, cycle_us, "us", "", "compute time of the haptic cycle", false)
SIGNAL(loop, double, lateness_us, "us", "", "start of the tick after its deadline", false)
// clang-format on
