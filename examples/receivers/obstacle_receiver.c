/* Receives echogrid's obstacle view, and says STOP whenever it may not be relied upon.
 *
 *     cc -O2 -Wall -Wextra -Werror -o obstacle_receiver obstacle_receiver.c
 *     ./obstacle_receiver unix:/run/robot/obstacles.sock [TIMEOUT_MS]
 *     ./obstacle_receiver udp:0.0.0.0:7654 [TIMEOUT_MS]
 *
 * One line for each change: GO with the speed limit, STOP with the reason; and how many frames were lost.
 * The layout is that of docs/obstacle-sensor.md. Linux; any byte order. */
#define _POSIX_C_SOURCE 200809L

#include <arpa/inet.h>
#include <poll.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

enum { HEADER_BYTES = 64, SECTOR_BYTES = 8, CHECK_BYTES = 4, LONGEST = 65535, VERSION = 1 };

struct frame {
    uint32_t sequence;
    uint64_t stamp_ns;
    bool stop;
    uint8_t reason;
    float speed_limit; /* m/s */
};

struct watch {
    uint64_t timeout_ns;
    bool one_clock; /* the sender runs on this machine: its stamps tell how old a frame is */
    bool heard;
    bool timed_out;
    uint64_t heard_ns;
    struct frame last;
};

static uint64_t little(const uint8_t *bytes, int count)
{
    uint64_t value = 0;
    while (count-- > 0)
        value = value << 8 | bytes[count];
    return value;
}

/* CRC-32 as in zlib and Ethernet. */
static uint32_t crc32(const uint8_t *bytes, size_t count)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < count; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    return ~crc;
}

/* Whether the bytes are exactly one frame of this version. */
static bool decoded(const uint8_t *data, size_t length, struct frame *frame)
{
    if (length < HEADER_BYTES + CHECK_BYTES || memcmp(data, "EGOV", 4) != 0 || data[4] != VERSION)
        return false;
    if (little(data + 12, 2) != length)
        return false;
    if (length != HEADER_BYTES + SECTOR_BYTES * (size_t)little(data + 14, 2) + CHECK_BYTES)
        return false;
    if (crc32(data, length - CHECK_BYTES) != (uint32_t)little(data + length - CHECK_BYTES, 4))
        return false;
    frame->stop = data[5] & 1;
    frame->reason = data[6];
    frame->sequence = (uint32_t)little(data + 8, 4);
    frame->stamp_ns = little(data + 16, 8);
    uint32_t bits = (uint32_t)little(data + 32, 4);
    memcpy(&frame->speed_limit, &bits, sizeof bits);
    return true;
}

/* Takes a datagram; how many before it were lost. What is invalid or old changes nothing. */
static uint32_t take(struct watch *watch, const uint8_t *data, size_t length, uint64_t now_ns)
{
    struct frame frame;
    uint32_t lost = 0;
    if (!decoded(data, length, &frame))
        return 0;
    if (watch->one_clock && now_ns > frame.stamp_ns && now_ns - frame.stamp_ns > watch->timeout_ns)
        return 0;
    if (watch->heard) {
        if (frame.stamp_ns <= watch->last.stamp_ns)
            return 0; /* a repeated one, or one that was overtaken */
        lost = frame.sequence - watch->last.sequence - 1;
        if (lost >= 0x80000000u)
            lost = 0; /* a sender that was started anew counts from 0 */
    }
    watch->heard = true;
    watch->heard_ns = now_ns;
    watch->last = frame;
    return lost;
}

/* GO or STOP, and why. */
static void verdict(struct watch *watch, uint64_t now_ns, char *text, size_t size)
{
    static const char *const reasons[] = {"", "near", "silent", "unknown", "stale"};
    if (watch->heard && now_ns - watch->heard_ns > watch->timeout_ns) {
        watch->heard = false; /* whoever speaks next is believed, whatever its clock says */
        watch->timed_out = true;
    }
    if (!watch->heard && watch->timed_out)
        snprintf(text, size, "STOP no valid frame for %u ms", (unsigned)(watch->timeout_ns / 1000000));
    else if (!watch->heard)
        snprintf(text, size, "STOP no valid frame yet");
    else if (watch->last.stop)
        snprintf(text, size, "STOP %s", watch->last.reason < 5 ? reasons[watch->last.reason] : "unknown reason");
    else
        snprintf(text, size, "GO %.2f m/s", (double)watch->last.speed_limit);
}

static uint64_t now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (uint64_t)time.tv_sec * 1000000000u + (uint64_t)time.tv_nsec;
}

static int give_up(const char *what)
{
    perror(what);
    exit(1);
}

static int receiving(char *address)
{
    int bound;
    if (strncmp(address, "unix:", 5) == 0) {
        struct sockaddr_un at = {.sun_family = AF_UNIX};
        const char *path = address + 5;
        if (strlen(path) >= sizeof at.sun_path) {
            fprintf(stderr, "%s: longer than a socket's path may be\n", path);
            exit(2);
        }
        strcpy(at.sun_path, path);
        struct stat found;
        if (stat(path, &found) == 0 && S_ISSOCK(found.st_mode))
            unlink(path); /* it is left of an earlier run */
        bound = socket(AF_UNIX, SOCK_DGRAM, 0);
        if (bound < 0 || bind(bound, (struct sockaddr *)&at, sizeof at) < 0)
            give_up(path);
        return bound;
    }
    char *port = strrchr(address, ':');
    struct sockaddr_in at = {.sin_family = AF_INET};
    if (strncmp(address, "udp:", 4) != 0 || port == address + 3) {
        fprintf(stderr, "%s: expected unix:PATH or udp:HOST:PORT\n", address);
        exit(2);
    }
    *port = '\0';
    at.sin_port = htons((uint16_t)atoi(port + 1));
    if (inet_pton(AF_INET, address + 4, &at.sin_addr) != 1) {
        fprintf(stderr, "%s: no IPv4 address\n", address + 4);
        exit(2);
    }
    bound = socket(AF_INET, SOCK_DGRAM, 0);
    if (bound < 0 || bind(bound, (struct sockaddr *)&at, sizeof at) < 0)
        give_up(address + 4);
    return bound;
}

int main(int count, char **arguments)
{
    static uint8_t data[LONGEST];
    char shown[64] = "", text[64];
    if (count < 2 || count > 3) {
        fprintf(stderr, "usage: %s unix:PATH|udp:HOST:PORT [TIMEOUT_MS]\n", arguments[0]);
        return 2;
    }
    unsigned timeout_ms = count == 3 ? (unsigned)atoi(arguments[2]) : 200;
    struct watch watch = {.timeout_ns = timeout_ms * UINT64_C(1000000)};
    watch.one_clock = strncmp(arguments[1], "unix:", 5) == 0;
    struct pollfd waiting = {.fd = receiving(arguments[1]), .events = POLLIN};
    setvbuf(stdout, NULL, _IOLBF, 0);
    for (;;) {
        verdict(&watch, now(), text, sizeof text);
        if (strcmp(text, shown) != 0) {
            puts(text);
            strcpy(shown, text);
        }
        if (poll(&waiting, 1, (int)(timeout_ms / 4 + 1)) <= 0)
            continue;
        ssize_t length = recv(waiting.fd, data, sizeof data, 0);
        if (length < 0)
            continue;
        uint32_t lost = take(&watch, data, (size_t)length, now());
        if (lost > 0)
            printf("LOST %u\n", lost);
    }
}
