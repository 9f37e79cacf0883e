#!/bin/sh
# The guest's first process: root = the guest's tree over the host's root, read-only, under a tmpfs.
export PATH=/bin
fail() { echo "bench: $1"; exec poweroff -f; }
share() { mount -t 9p -o "$3,trans=virtio,version=9p2000.L,msize=512000,cache=$4" "$1" "$2" || fail "no $1"; }

mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
for module in $(cat /modules/order); do
    insmod "/modules/$module" || fail "no $module"
done

share host /host ro loose
share tree /tree ro loose
mount -t tmpfs -o size=1g tmpfs /written
mkdir /written/upper /written/work
mount -t overlay -o lowerdir=/tree:/host,upperdir=/written/upper,workdir=/written/work overlay /root \
    || fail "no overlay"

mkdir -p /root/run /root/proc /root/sys /root/dev
mount --move /proc /root/proc
mount --move /sys /root/sys
mount --move /dev /root/dev
mkdir -p /root/dev/pts /root/dev/shm
mount -t devpts -o ptmxmode=666,gid=5,mode=620 devpts /root/dev/pts
mount -t tmpfs tmpfs /root/dev/shm
mount -t tmpfs -o mode=755 tmpfs /root/run
mkdir -p /root/run/systemd/system /root/run/bench-out
share out /root/run/bench-out rw none
cp -a /units/. /root/run/systemd/system/
rm -f /root/.dockerenv
exec switch_root /root /lib/systemd/systemd
