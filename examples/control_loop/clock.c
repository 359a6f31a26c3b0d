/* A faster clock for a process: seconds since CLOCK_BASE pass CLOCK_SPEED times as fast, for whoever asks and whoever sleeps.

   Preloaded into the control's processes it shortens waiting and changes no position: the control counts its own servo periods.
   CLOCK_BASE is "realtime,monotonic", ns. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <poll.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/select.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static const int64_t SECOND = 1000000000LL;
static double speed = 1;
static int64_t base[2];

__attribute__((constructor)) static void begin(void)
{
    const char *factor = getenv("CLOCK_SPEED"), *bases = getenv("CLOCK_BASE");
    char *rest;
    if (!factor || !bases)
        return;
    base[0] = strtoll(bases, &rest, 10);
    base[1] = strtoll(rest + 1, NULL, 10);
    speed = atof(factor);
}

static int64_t ns(const struct timespec *t) { return t->tv_sec * SECOND + t->tv_nsec; }
static struct timespec of_ns(int64_t n) { return (struct timespec){n / SECOND, n % SECOND}; }

/* 0 for the time of day, 1 for monotonic clocks, -1 for others. */
static int kind(clockid_t clock)
{
    switch (clock) {
    case CLOCK_REALTIME: case CLOCK_REALTIME_COARSE: return 0;
    case CLOCK_MONOTONIC: case CLOCK_MONOTONIC_RAW: case CLOCK_MONOTONIC_COARSE: case CLOCK_BOOTTIME: return 1;
    default: return -1;
    }
}

static struct timespec shorter(int64_t span) { return of_ns(span / speed); }
static struct timespec really(int which, int64_t told) { return of_ns(base[which] + (told - base[which]) / speed); }

int clock_gettime(clockid_t clock, struct timespec *t)
{
    int failed = syscall(SYS_clock_gettime, clock, t), which = kind(clock);
    if (!failed && which >= 0)
        *t = of_ns(base[which] + (ns(t) - base[which]) * speed);
    return failed;
}

int gettimeofday(struct timeval *restrict t, void *restrict zone)
{
    struct timespec now;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &now);
    if (t)
        *t = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
    return 0;
}

time_t time(time_t *t)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (t)
        *t = now.tv_sec;
    return now.tv_sec;
}

int clock_nanosleep(clockid_t clock, int flags, const struct timespec *until, struct timespec *rest)
{
    int which = kind(clock);
    struct timespec t = *until;
    if (which >= 0)
        t = flags & TIMER_ABSTIME ? really(which, ns(until)) : shorter(ns(until));
    return syscall(SYS_clock_nanosleep, clock, flags, &t, rest) ? errno : 0;
}

int nanosleep(const struct timespec *span, struct timespec *rest)
{
    int failed = clock_nanosleep(CLOCK_MONOTONIC, 0, span, rest);
    if (failed)
        errno = failed;
    return failed ? -1 : 0;
}

int usleep(useconds_t us)
{
    struct timespec t = of_ns(us * 1000LL);
    return nanosleep(&t, NULL);
}

unsigned sleep(unsigned s)
{
    struct timespec t = of_ns(s * SECOND);
    nanosleep(&t, NULL);
    return 0;
}

int select(int count, fd_set *in, fd_set *out, fd_set *other, struct timeval *limit)
{
    struct timespec t;
    if (limit)
        t = shorter(limit->tv_sec * SECOND + limit->tv_usec * 1000LL);
    return syscall(SYS_pselect6, count, in, out, other, limit ? &t : NULL, NULL);
}

int poll(struct pollfd *list, nfds_t count, int ms)
{
    struct timespec t = shorter(ms * 1000000LL);
    return syscall(SYS_ppoll, list, count, ms >= 0 ? &t : NULL, NULL, 8);
}

int sem_timedwait(sem_t *restrict sem, const struct timespec *restrict until)
{
    int (*wait)(sem_t *, const struct timespec *) = dlsym(RTLD_NEXT, "sem_timedwait");
    struct timespec t = really(0, ns(until));
    return wait(sem, &t);
}

int sem_clockwait(sem_t *restrict sem, clockid_t clock, const struct timespec *restrict until)
{
    int (*wait)(sem_t *, clockid_t, const struct timespec *) = dlsym(RTLD_NEXT, "sem_clockwait");
    int which = kind(clock);
    struct timespec t = which < 0 ? *until : really(which, ns(until));
    return wait(sem, clock, &t);
}
