/* Driver of a haptic device in C: a shared object with these four functions, named in a scene by
 *
 *     arms: {leader: {driver: ./my_device.so}}
 *
 * Palpate calls them from its real-time thread, without the Python interpreter: open once, then read and write in turn
 * at the rate of the device, and close once; `palpate device bench` does so for each of its steps. Values are in SI
 * units, in the axes of the device's base, whose origin and orientation in the scene are arms.leader.base. A driver is
 * compiled with this header alone:
 *
 *     cc -O2 -shared -fPIC -I FOLDER_OF_THIS_FILE my_device.c -o my_device.so
 *
 * `palpate device list` prints the folder.
 */
#ifndef PALPATE_DRIVER_H
#define PALPATE_DRIVER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Version of these structs and functions. Palpate refuses a driver of another version. */
#define PALPATE_DRIVER_ABI 1

/* Facts about the device, filled in by open, which finds them all zero. Those from resolution on may stay zero, which
 * means unknown; `palpate device bench` measures them. The passivity layer then assumes no friction, and takes more
 * force.
 */
typedef struct palpate_driver_info {
  uint32_t abi;        /* set to PALPATE_DRIVER_ABI by the driver */
  char name[64];       /* for messages and records */
  double rate;         /* rate at which Palpate calls read and write [Hz], 50 to 10000 */
  double force_max;    /* largest force that the device may be commanded [N]; 0: it renders no force */
  double moment_max;   /* largest moment [N m]; 0: forces only */
  double workspace[3]; /* lengths of the workspace along the base axes [m] */
  double resolution;   /* step of the measured position, or six times its noise if that is larger [m] */
  double mass;         /* moving mass at the handle [kg] */
  double delay;        /* time from a measurement to the force on the hand [s] */
  double friction;     /* dry friction that certainly resists the handle; needs resolution [N] */
  double damping;      /* viscous friction that certainly resists the handle; needs resolution [N s/m] */
} palpate_driver_info;

/* Buttons of the handle. The clutch acts on this hand at once; the others are pedals of the console. */
#define PALPATE_BUTTON_CLUTCH 1u /* the hand moves and the tool stays */
#define PALPATE_BUTTON_CAMERA 2u /* the hand moves the endoscope */
#define PALPATE_BUTTON_COAG 4u   /* coagulation, which is reported to programs */
/* The device's own button i from 0, whatever it does: `palpate ros device` publishes each. */
#define PALPATE_BUTTON_OWN(i) (256u << (i))

/* One measurement, filled in by read. */
typedef struct palpate_driver_state {
  double X_LH[16]; /* pose of the handle H in the base L, row by row; the last row is 0 0 0 1 [m] */
  double V_LH[6];  /* velocity of the handle: linear [m/s], angular [rad/s]; used only if has_velocity is 1 */
  int32_t has_velocity;
  uint32_t buttons; /* bits of PALPATE_BUTTON_... */
  double gripper;   /* pinch angle, 0: closed [rad] */
} palpate_driver_state;

/* Opens the device. argument: the text after the first ':' behind the file name, or "". Returns an object for the
 * other functions, or NULL after writing the reason to why (size bytes). */
void* palpate_driver_open(const char* argument, palpate_driver_info* info, char* why, size_t size);

/* Reads the device. Returns 0, or another number if it cannot be read, which ends the session with zero force. */
int palpate_driver_read(void* device, palpate_driver_state* state);

/* Commands a wrench on the hand: force [N], moment [N m]. Returns 0, or another number on failure. If read or write
 * does not return within 12 ms, another thread calls this function with zeros: it must allow that. */
int palpate_driver_write(void* device, const double wrench[6]);

/* Closes the device; the last wrench written was zero. */
void palpate_driver_close(void* device);

#ifdef __cplusplus
}
#endif
#endif
