"""MCAP files, with or without an index, read by Foxglove's own library."""

from collections import Counter
from collections.abc import Iterator
import os
from pathlib import Path
from typing import IO, NamedTuple

from mcap.reader import NonSeekingReader, SeekingReader
from mcap.records import Channel as McapChannel, Message, Schema
from mcap.stream_reader import StreamReader


class Channel(NamedTuple):
    """The messages of one type on a topic, from one publisher."""

    key: int  # unique in its file
    topic: str
    kind: str  # ROS 2's form of the type, 'package/msg/Name'
    encoding: str  # 'cdr', 'ros1' or another one
    count: int  # type: ignore[assignment]  # messages; a tuple has a method of that name


class McapFile:
    """
    An open MCAP file.

    Parameters
    ----------
    path : Path
        The file.

    Attributes
    ----------
    channels : list of Channel
        Channels with messages.

    """

    def __init__(self, path: Path) -> None:
        self._stream: IO[bytes] = open(path, 'rb')
        try:
            self._limit = os.fstat(self._stream.fileno()).st_size  # of a record [bytes]
            self._reader = SeekingReader(self._stream, validate_crcs=True,
                                         record_size_limit=self._limit)
            self._unordered: set[str] = set()
            self._is_indexed = self._read_index() or self._scan()
        except BaseException:
            self._stream.close()
            raise

    def close(self) -> None:
        """Close the file."""
        self._stream.close()

    def messages(self, channels: list[Channel]) -> Iterator[tuple[Channel, int, bytes]]:
        """Yield channel, time of recording [ns] and data of each message, by that time."""
        known = {channel.key: channel for channel in channels}
        topics = {channel.topic for channel in channels}
        if self._is_indexed:
            found = self._reader.iter_messages(topics)
        else:
            self._stream.seek(0)
            reader = NonSeekingReader(self._stream, True, record_size_limit=self._limit)
            found = reader.iter_messages(topics, log_time_order=not topics.isdisjoint(
                self._unordered))
        for _, channel, message in found:
            if channel.id in known:
                yield known[channel.id], message.log_time, message.data

    def _read_index(self) -> bool:
        """Set the channels from the summary section; return whether it is complete."""
        summary = self._reader.get_summary()
        if summary is None or summary.statistics is None or not summary.chunk_indexes:
            return False
        counts = summary.statistics.channel_message_counts
        complete = sum(counts.values()) == summary.statistics.message_count and all(
            id_ in summary.channels and summary.channels[id_].schema_id in {0, *summary.schemas}
            for id_ in counts)
        if complete:
            self._set_channels(summary.channels, summary.schemas, counts)
        return complete

    def _scan(self) -> bool:
        """Set the channels from the messages themselves; return False: there is no index."""
        self._stream.seek(0)
        channels: dict[int, McapChannel] = {}
        schemas: dict[int, Schema] = {}
        counts: Counter[int] = Counter()
        newest: dict[str, int] = {}
        for record in StreamReader(self._stream, record_size_limit=self._limit).records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, McapChannel):
                channels[record.id] = record
            elif isinstance(record, Message):
                counts[record.channel_id] += 1
                topic = channels[record.channel_id].topic
                if record.log_time < newest.get(topic, 0):
                    self._unordered.add(topic)
                newest[topic] = record.log_time
        self._set_channels(channels, schemas, counts)
        return False

    def _set_channels(self, channels: dict[int, McapChannel], schemas: dict[int, Schema],
                      counts: 'dict[int, int] | Counter[int]') -> None:
        self.channels = []
        for id_, count in counts.items():
            channel = channels[id_]
            name = schemas[channel.schema_id].name if channel.schema_id else 'no type'
            if count:
                self.channels.append(Channel(
                    id_, channel.topic, _ros2_name(name), channel.message_encoding, count))


def _ros2_name(name: str) -> str:
    """Return a type's name as ROS 2 writes it; ROS 1 writes 'package/Name'."""
    package, _, rest = name.partition('/')
    return f'{package}/msg/{rest}' if rest and '/' not in rest else name
