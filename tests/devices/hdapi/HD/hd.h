/* The part of OpenHaptics' HDAPI that palpate/devices/openhaptics.c uses, declared as the vendor's reference guide
 * names and types it. */
#ifndef HD_HD_H
#define HD_HD_H
typedef unsigned int HHD, HDerror, HDenum, HDCallbackCode;
typedef unsigned long HDSchedulerHandle;
typedef int HDint;
typedef double HDdouble;
typedef unsigned short HDushort;
typedef const char* HDstring;
typedef struct {
  HDerror errorCode;
  int internalErrorCode;
  HHD hHD;
} HDErrorInfo;
typedef HDCallbackCode (*HDSchedulerCallback)(void*);
#define HDCALLBACK
#define HD_DEFAULT_DEVICE ((HDstring)0)
#define HD_DEVICE_ERROR(x) ((x).errorCode != 0)
#define HD_CALLBACK_DONE 0
#define HD_CALLBACK_CONTINUE 1
#define HD_MAX_SCHEDULER_PRIORITY 65535
#define HD_CURRENT_TRANSFORM 0x2052
#define HD_CURRENT_BUTTONS 0x2000
#define HD_CURRENT_FORCE 0x2700
#define HD_NOMINAL_MAX_FORCE 0x2603
#define HD_FORCE_OUTPUT 0x4000
#define HD_DEVICE_BUTTON_1 1
#define HD_DEVICE_BUTTON_2 2
#define HD_DEVICE_BUTTON_3 4
#define HD_DEVICE_BUTTON_4 8
HHD hdInitDevice(HDstring name);
void hdMakeCurrentDevice(HHD id);
void hdDisableDevice(HHD id);
void hdBeginFrame(HHD id);
void hdEndFrame(HHD id);
void hdGetDoublev(HDenum name, HDdouble* values);
void hdGetIntegerv(HDenum name, HDint* values);
void hdSetDoublev(HDenum name, const HDdouble* values);
void hdEnable(HDenum what);
HDErrorInfo hdGetError(void);
void hdStartScheduler(void);
void hdStopScheduler(void);
HDSchedulerHandle hdScheduleAsynchronous(HDSchedulerCallback callback, void* data, HDushort priority);
void hdUnschedule(HDSchedulerHandle handle);
#endif
