// Packs the samples of a transmit into a `Block` of firmware/stream, as little-endian beats of 64 bits:
// {epoch, faults, beam, sequence}, the samples, zeros up to a multiple of 32 bytes. See docs/fpga.md.
//
// A pulse of `start` begins a transmit; its samples come from the next clock on. They fill one of two banks, while
// the other one is sent. If no bank is free, the transmit is dropped, and its number is missing from the blocks.
module packer #(
    parameter CHANNELS = 32,       // numbers a sample: elements of RF, twice the elements of I/Q; a multiple of 4
    parameter BITS = 14,           // of a number, 3 to 16
    parameter SAMPLES = 280        // samples a block
) (
    input wire clock,
    input wire reset,
    input wire enable,             // low: `start` is ignored
    input wire start,
    input wire [15:0] beam,        // of the transmit
    input wire [7:0] epoch,        // differs between two starts of the front end: the processor sets it
    input wire [CHANNELS*BITS-1:0] s_axis_tdata,   // channel CHANNELS - 1, ..., channel 0; I before Q
    input wire [1:0] s_axis_tuser, // {samples were lost before, the converter clipped}
    input wire s_axis_tvalid,
    output wire s_axis_tready,
    input wire waits,              // constant; low: the source does not wait, and a sample before tready is lost
    output reg [63:0] m_axis_tdata,
    output reg m_axis_tvalid,
    input wire m_axis_tready,
    output reg m_axis_tlast
);
    localparam WORDS = CHANNELS / 4;
    localparam BANK = WORDS * SAMPLES;
    localparam BEATS = (BANK + 4) / 4 * 4;
    localparam A = $clog2(2 * BANK);
    localparam W = WORDS > 1 ? $clog2(WORDS) : 1;
    localparam B = $clog2(BEATS);
    localparam C = $clog2(SAMPLES + 1);

    localparam MEMORIES = (2 * BANK + 1023) / 1024;

    reg [1:0] full;
    reg [63:0] headers [0:1];

    // --- Samples to words of a bank.
    reg recording, bank, shifting;
    reg [31:0] transmit;
    reg [55:0] header;
    reg [1:0] faults;
    reg [C-1:0] samples;           // offered to this block
    reg [A-1:0] address, next_address;
    reg [W-1:0] word;
    reg [CHANNELS*BITS-1:0] shift;
    wire [63:0] numbers;
    wire [CHANNELS-1:0] clipped;
    genvar k;
    generate
        for (k = 0; k < 4; k = k + 1) begin : number
            assign numbers[16*k +: 16] = {{17-BITS{shift[BITS*k+BITS-1]}}, shift[BITS*k +: BITS-1]};
        end
        for (k = 0; k < CHANNELS; k = k + 1) begin : channel
            wire [BITS-1:0] value = s_axis_tdata[BITS*k +: BITS];
            // ±(2^(BITS-1) - 1), and the most negative number.
            assign clipped[k] = value[BITS-1] ? value[BITS-2:1] == 0 : &value[BITS-2:0];
        end
    endgenerate

    wire last_word = word == WORDS[W-1:0] - 1'b1;
    wire begins = start && enable;
    wire all_offered = samples == SAMPLES[C-1:0];
    wire offered = recording && s_axis_tvalid && !all_offered && (s_axis_tready || !waits);
    wire taken = offered && s_axis_tready;
    // The words of its last sample are in memory before they are sent.
    wire closes = recording && (all_offered || begins);
    wire next_bank = bank ^ closes;
    wire [1:0] new_faults = faults | (offered ? {s_axis_tuser[1] | !s_axis_tready, s_axis_tuser[0] | (|clipped)} : 2'd0)
        | {closes && !all_offered, 1'b0};
    assign s_axis_tready = !shifting || last_word;

    // --- Beats, 3 stages behind `beat`.
    reg read_bank;
    reg [B-1:0] beat;
    reg [A-1:0] read_address;
    reg [A-1:0] memory_1, memory_2;
    reg [63:0] other_1, other_2;
    reg [2:1] valid, last, of_memory;
    wire advance = !m_axis_tvalid || m_axis_tready;
    wire loads = advance && full[read_bank];
    wire last_beat = beat == BEATS[B-1:0] - 1'b1;
    wire loads_word = beat != 0 && beat <= BANK[B-1:0];

    wire [A+9:0] written = {10'd0, address}, needed = {10'd0, read_address};
    generate
        for (k = 0; k < MEMORIES; k = k + 1) begin : part
            (* no_rw_check *) reg [63:0] words [0:(2*BANK < 1024 ? 2*BANK : 1024)-1];
            reg [63:0] read, held;
            wire [63:0] own = memory_2 == k[A-1:0] ? held : 64'd0;
            wire [63:0] found;     // of this memory and those before
            if (k == 0) assign found = own;
            else assign found = part[k-1].found | own;
            always @(posedge clock) begin
                if (shifting && written[A+9:10] == k[A-1:0]) words[written[9:0]] <= numbers;
                if (advance) begin
                    read <= words[needed[9:0]];
                    held <= read;
                end
            end
        end
    endgenerate

    always @(posedge clock) begin
        shift <= taken ? s_axis_tdata : shift >> 4 * BITS;
        word <= taken ? {W{1'b0}} : word + 1'b1;
        shifting <= taken || (shifting && !last_word);
        address <= taken ? next_address : address + 1'b1;
        faults <= new_faults;
        if (offered) begin
            samples <= samples + 1'b1;
            next_address <= next_address + WORDS[A-1:0];
        end
        if (closes) begin
            full[bank] <= 1;
            headers[bank] <= {header[55:48], 6'd0, new_faults, header[47:0]};
            recording <= 0;
            bank <= next_bank;
        end
        if (begins) begin
            transmit <= transmit + 1;
            recording <= !full[next_bank];
            header <= {epoch, beam, transmit};
            faults <= 0;
            samples <= 0;
            next_address <= next_bank ? BANK[A-1:0] : {A{1'b0}};
        end
        if (advance) begin
            {m_axis_tvalid, valid} <= {valid, loads};
            {m_axis_tlast, last} <= {last, loads && last_beat};
            of_memory <= {of_memory[1], loads_word};
            {memory_2, memory_1} <= {memory_1, needed[A+9:10]};
            other_1 <= beat == 0 ? headers[read_bank] : 64'd0;
            other_2 <= other_1;
            m_axis_tdata <= of_memory[2] ? part[MEMORIES-1].found : other_2;
        end
        if (loads) begin
            beat <= last_beat ? {B{1'b0}} : beat + 1'b1;
            if (loads_word) read_address <= read_address + 1'b1;
            if (last_beat) begin
                full[read_bank] <= 0;
                read_bank <= !read_bank;
                read_address <= read_bank ? {A{1'b0}} : BANK[A-1:0];
            end
        end
        if (reset) begin
            full <= 0;
            recording <= 0;
            bank <= 0;
            shifting <= 0;
            transmit <= 0;
            read_bank <= 0;
            beat <= 0;
            read_address <= 0;
            {m_axis_tvalid, valid} <= 0;
        end
    end
endmodule
